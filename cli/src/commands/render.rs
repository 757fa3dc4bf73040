//! `seamwright render`: pictures of a UV-mapped mesh.

use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::load::load;
use crate::save;

/// Runs `seamwright render`.
pub fn render(args: &RenderArgs) -> Result<(), Failure> {
    save::check("-o", &args.output)?;
    let loaded = load(&args.file)?;
    let (_mesh, _uv) = loaded.mapped()?;
    Err(Failure::Unreached("render: this version draws no pictures yet".into()))
}
