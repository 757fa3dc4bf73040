//! The words of `unwrap`.

use super::group::GroupArg;
use super::learning::LearningArgs;
use super::method::MethodArg;
use super::parts::{PartsArg, parts_or_off};
use super::run::RunArgs;
use super::settings::SettingsArgs;
use super::writing::WritingArgs;
use clap::Args;
use std::path::PathBuf;

/// `unwrap`.
#[derive(Debug, Args)]
pub struct UnwrapArgs {
    /// The mesh (.obj, .ply, .stl, .off, .fbx, .glb, .gltf); - is standard input. Existing UVs are replaced
    pub mesh: PathBuf,
    /// What is written.
    #[command(flatten)]
    pub writing: WritingArgs,
    /// What shares an atlas, a unit square of its own
    #[arg(long, value_enum, default_value_t = GroupArg::Scene)]
    pub group: GroupArg,
    /// What makes the map
    #[arg(long, value_enum, default_value_t = MethodArg::Exact)]
    pub method: MethodArg,
    /// How the atlas is made.
    #[command(flatten)]
    pub settings: SettingsArgs,
    /// Cut along the borders of the object's parts: off, auto, a number of parts, or published (see `segment`)
    #[arg(long, value_name = "N|auto|off", default_value = "off", value_parser = parts_or_off)]
    pub parts: PartsArg,
    /// Cut along the borders of these parts: .seg, .json, or a coloured .ply or .glb of the mesh
    #[arg(long, value_name = "FILE", conflicts_with = "parts")]
    pub labels: Option<PathBuf>,
    /// Put each chart of the OBJ in a group named after its part and chart
    #[arg(long)]
    pub groups: bool,
    /// Keep the borders of the UVs that the file has as cuts
    #[arg(long)]
    pub keep_seams: bool,
    /// Also draw the result
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// Also write a report; - is standard output
    #[arg(long, value_name = "REPORT.json|-")]
    pub json: Option<PathBuf>,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
    /// How maps are trained: last, since its heading holds for all that follows.
    #[command(flatten)]
    pub learning: LearningArgs,
}
