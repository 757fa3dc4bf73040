//! `seamwright demo`: the main job on a built-in mesh, so that one command shows what the program does.

use crate::args::demo::DemoArgs;
use crate::args::group::GroupArg;
use crate::args::method::MethodArg;
use crate::args::parts::PartsArg;
use crate::base::failure::Failure;
use crate::formats::format::Format;
use crate::formats::loaded::load_obj;
use crate::formats::target::Target;
use crate::jobs::job::{Job, PartsSource};
use seamwright_core::pipeline::Settings;
use std::fs;
use std::path::Path;

/// The built-in mesh: its name and its OBJ.
const FIXTURE: (&str, &[u8]) = ("quadruped", include_bytes!("../../../fixtures/quadruped.obj"));

/// Runs `seamwright demo`: writes the mesh with its atlas, a picture and the report to a folder.
pub fn demo(args: &DemoArgs) -> Result<(), Failure> {
    let folder = &args.output;
    fs::create_dir_all(folder).map_err(|e| Failure::output("-o", folder, &e))?;
    let (name, bytes) = FIXTURE;
    let job = Job {
        target: Target::new(&folder.join(name).with_extension("obj"), Format::Obj),
        sheet: Some(folder.join(name).with_extension("png")),
        json: Some(folder.join(name).with_extension("json")),
        save_map: None,
        curves: None,
        method: MethodArg::Exact,
        learning: None,
        settings: Settings::default(),
        limit: None,
        group: GroupArg::Scene,
        parts: PartsSource::Shape(PartsArg::Off),
        groups: false,
        keep_seams: false,
        inputs: Vec::new(),
        run: args.run,
    };
    job.run(Path::new(name), || load_obj(Path::new(name), bytes.to_vec()))
}
