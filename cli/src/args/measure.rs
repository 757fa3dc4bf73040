//! The words of `measure`.

use super::writing::FORMATS;
use clap::{Args, ValueEnum};
use seamwright_core::judge::measure::RESOLUTION;
use std::path::PathBuf;

/// `measure`.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    /// UV-mapped files
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// What standard input holds, where a file is -
    #[arg(long, value_name = "FORMAT", value_parser = FORMATS)]
    pub format: Option<String>,
    /// Which set of UVs: TEXCOORD_N of a glTF, texcoordN of a PLY
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=15))]
    pub uv_set: u32,
    /// Print JSON in place of a table: an object for one file, a list for several
    #[arg(long)]
    pub json: bool,
    /// How the sky over a vertex is weighed
    #[arg(long, value_enum, default_value_t = Sky::Uniform)]
    pub exposure: Sky,
    /// Exposure rays of each vertex
    #[arg(long, value_name = "COUNT", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub rays: u32,
    /// Say how far the file's charts agree with these partitions (.seg, .json, coloured .ply or .glb), each and on the mean
    #[arg(long, value_name = "LABELS", num_args = 1..)]
    pub reference: Vec<PathBuf>,
    /// Compare this partition with the references in place of the charts
    #[arg(long, value_name = "FILE", requires = "reference")]
    pub labels: Option<PathBuf>,
    /// Texels a side at which overlap and utilisation are sampled; 0 leaves them out
    #[arg(long, value_name = "TEXELS", default_value_t = RESOLUTION, value_parser = clap::value_parser!(u32).range(0..=16384))]
    pub resolution: u32,
}

/// How the sky over a vertex is weighed in `measure`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Sky {
    /// Every direction alike, as libigl does
    Uniform,
    /// By the cosine with the normal, as light falls in; what unwrap uses
    Cosine,
    /// No rays, no figures of exposure
    None,
}
