//! The words of `check`.

use super::group::GroupArg;
use super::settings::crack;
use super::writing::FORMATS;
use clap::Args;
use std::path::PathBuf;

/// `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// A UV-mapped file
    pub file: PathBuf,
    /// The mesh that was unwrapped: the file must be this mesh, but for UVs
    #[arg(long, value_name = "FILE")]
    pub input: Option<PathBuf>,
    /// Texels a side: all UVs lie in the unit square, and charts keep --padding
    #[arg(long, value_name = "TEXELS", requires = "padding", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub size: Option<u32>,
    /// Texels from each chart to the next
    #[arg(long, value_name = "TEXELS", requires = "size", value_parser = clap::value_parser!(u32).range(0..=65536))]
    pub padding: Option<u32>,
    /// What shares a unit square; sets of UVs that do not may lie over one another
    #[arg(long, value_enum, default_value_t = GroupArg::Scene)]
    pub group: GroupArg,
    /// Closed cracks, as unwrapped with --weld: charts whose sides have the same UVs, and ends within this share of the mesh's diagonal,
    /// are one
    #[arg(long, value_name = "SHARE", value_parser = crack)]
    pub weld: Option<f64>,
    /// Charts may lie on others as a whole, mirrored too, or one square to the right, as unwrap --stack lays them
    #[arg(long)]
    pub stacked: bool,
    /// What standard input holds, where a file is -
    #[arg(long, value_name = "FORMAT", value_parser = FORMATS)]
    pub format: Option<String>,
    /// Which set of UVs: TEXCOORD_N of a glTF, texcoordN of a PLY
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=15))]
    pub uv_set: u32,
}
