//! What a job is asked for.

use crate::args::group::GroupArg;
use crate::args::method::MethodArg;
use crate::args::parts::PartsArg;
use crate::args::run::RunArgs;
use crate::formats::reading::Reading;
use crate::formats::target::Target;
use crate::training::trainer::Trainer;
use seamwright_core::pipeline::Settings;
use std::path::PathBuf;
use std::time::Duration;

/// Everything that a run needs but the mesh.
pub struct Job {
    /// The mesh to write.
    pub target: Target,
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
    /// When it should be made.
    pub limit: Option<Duration>,
    /// What shares an atlas.
    pub group: GroupArg,
    /// Where parts come from.
    pub parts: PartsSource,
    /// Whether the OBJ has a group for each chart.
    pub groups: bool,
    /// Whether the borders of the UVs that are there stay cuts.
    pub keep_seams: bool,
    /// Other files that are read, with what messages call them.
    pub inputs: Vec<(&'static str, PathBuf)>,
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

impl Job {
    /// What is wanted of the file that comes in.
    pub fn reading(&self) -> Reading {
        Reading { uv_set: self.target.uv_set, copies: !self.target.format.has_instances() }
    }
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
