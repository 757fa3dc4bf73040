//! What a job is asked for.

use crate::args::method::MethodArg;
use crate::args::parts::PartsArg;
use crate::args::run::RunArgs;
use crate::training::trainer::Trainer;
use seamwright_core::pipeline::Settings;
use std::path::PathBuf;

/// Everything that a run needs but the mesh.
pub struct Job {
    /// The OBJ to write.
    pub output: PathBuf,
    /// The picture to write.
    pub sheet: Option<PathBuf>,
    /// The report to write; `-` is standard output.
    pub json: Option<PathBuf>,
    /// The file of trained maps to write.
    pub save_map: Option<PathBuf>,
    /// The picture of the losses to write.
    pub curves: Option<PathBuf>,
    /// What makes the map.
    pub method: MethodArg,
    /// How maps are trained, where they are.
    pub learning: Option<Trainer>,
    /// How the atlas is made.
    pub settings: Settings,
    /// Where parts come from.
    pub parts: PartsSource,
    /// Whether the OBJ has a group for each chart.
    pub groups: bool,
    /// Whether the borders of the UVs that are there stay cuts.
    pub keep_seams: bool,
    /// How it runs.
    pub run: RunArgs,
}

/// Where parts come from.
pub enum PartsSource {
    /// The shape, or nowhere.
    Shape(PartsArg),
    /// A file of labels.
    File(PathBuf),
}

impl PartsSource {
    /// For the report: the flag's value, or the file.
    pub(super) fn name(&self) -> String {
        match self {
            PartsSource::Shape(arg) => arg.name(),
            PartsSource::File(file) => file.display().to_string(),
        }
    }
}
