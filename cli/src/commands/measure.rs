//! `seamwright measure`: figures of UV-mapped meshes, whatever tool made them.

use crate::args::MeasureArgs;
use crate::failure::Failure;
use crate::load::load;

/// Runs `seamwright measure`.
pub fn measure(args: &MeasureArgs) -> Result<(), Failure> {
    for path in &args.files {
        let loaded = load(path)?;
        let (_mesh, _uv) = loaded.mapped()?;
    }
    let _ = args.json;
    Err(Failure::Unreached("measure: this version has no metrics yet".into()))
}
