//! `seamwright apply`: a saved map on its mesh, without training.

use crate::args::apply::ApplyArgs;
use crate::args::group::GroupArg;
use crate::args::method::MethodArg;
use crate::args::parts::PartsArg;
use crate::base::failure::Failure;
use crate::formats::format::Format;
use crate::formats::loaded::open;
use crate::jobs::job::{Job, PartsSource};
use crate::jobs::target::target;
use crate::training::map_file;
use crate::training::trainer::Trainer;

/// Runs `seamwright apply`.
pub fn apply(args: &ApplyArgs) -> Result<(), Failure> {
    let job = Job {
        target: target(&args.writing, &args.mesh)?,
        sheet: args.sheet.clone(),
        json: args.json.clone(),
        save_map: None,
        curves: None,
        method: MethodArg::Neural,
        learning: Some(Trainer::Fit(Box::new(map_file::read(&args.map)?))),
        settings: args.settings.to_core(),
        limit: args.settings.limit(),
        group: GroupArg::Scene,
        parts: PartsSource::Shape(PartsArg::Off),
        groups: false,
        keep_seams: false,
        inputs: vec![("--map", args.map.clone())],
        run: args.run,
    };
    job.check_settings()?;
    job.check_paths(&args.mesh)?;
    let stream = args.writing.format.as_deref().and_then(Format::named);
    job.run(&args.mesh, || open(&args.mesh, stream, job.reading()))
}
