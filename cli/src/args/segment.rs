//! The words of `segment`.

use super::parts::{PartsArg, parts};
use super::run::RunArgs;
use clap::Args;
use seamwright_core::pipeline;
use std::path::PathBuf;

/// `segment`.
#[derive(Debug, Args)]
pub struct SegmentArgs {
    /// The mesh (.obj, .ply, .stl, .off, .fbx, .glb, .gltf)
    pub mesh: PathBuf,
    /// What to write, by its ending: .seg (a label a line), .json (labels by face), coloured .ply or .glb
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// How many parts: auto, a number, or published (three clusters of shape diameter and graph cuts)
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = parts)]
    pub parts: PartsArg,
    /// Also draw parts and shape diameter
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// Seed of every random choice
    #[arg(long, default_value_t = pipeline::Settings::default().seed)]
    pub seed: u64,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}
