//! `seamwright unwrap`: a mesh in, the same mesh with an atlas out.

use crate::args::learning::LearningArgs;
use crate::args::method::MethodArg;
use crate::args::unwrap::UnwrapArgs;
use crate::base::failure::Failure;
use crate::formats::format::Format;
use crate::formats::loaded::open;
use crate::jobs::job::{Job, PartsSource};
use crate::jobs::target::target;
use crate::training::trainer::Trainer;
use seamwright_core::pipeline::Settings;

/// Further trials of the hybrid method.
const HYBRID: u32 = 40;

/// Runs `seamwright unwrap`.
pub fn unwrap(args: &UnwrapArgs) -> Result<(), Failure> {
    let mut settings = args.settings.to_core();
    if args.method == MethodArg::Hybrid && settings.search == Settings::default().search {
        settings.search = HYBRID;
    }
    let job = Job {
        target: target(&args.writing, &args.mesh)?,
        sheet: args.sheet.clone(),
        json: args.json.clone(),
        save_map: args.learning.save_map.clone(),
        curves: args.learning.curves.clone(),
        method: args.method,
        learning: trainer(args)?,
        settings,
        limit: args.settings.limit(),
        group: args.group,
        parts: args.labels.clone().map_or(PartsSource::Shape(args.parts), PartsSource::File),
        groups: args.groups,
        keep_seams: args.keep_seams,
        inputs: [("--labels", &args.labels), ("--settings", &args.learning.file)]
            .into_iter()
            .filter_map(|(flag, path)| Some((flag, path.clone()?)))
            .collect(),
        run: args.run,
    };
    job.check_settings()?;
    job.check_paths(&args.mesh)?;
    let stream = args.writing.format.as_deref().and_then(Format::named);
    job.run(&args.mesh, || open(&args.mesh, stream, job.reading()))
}

/// Settings of training; flags that only training knows are refused without it.
fn trainer(args: &UnwrapArgs) -> Result<Option<Trainer>, Failure> {
    if args.method == MethodArg::Neural {
        return Trainer::new(&args.learning, args.settings.seed).map(Some);
    }
    let LearningArgs { preset, file, steps, visibility, save_map, curves } = &args.learning;
    let given = [
        ("--preset", preset.is_some()),
        ("--settings", file.is_some()),
        ("--steps", steps.is_some()),
        ("--visibility", visibility.is_some()),
        ("--save-map", save_map.is_some()),
        ("--curves", curves.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((flag, _)) => {
            Err(Failure::Usage(format!("{flag}: --method {} does not learn; add --method neural", args.method.name())))
        }
        None => Ok(None),
    }
}
