//! The words of `render`.

use clap::Args;
use std::path::PathBuf;

/// `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A UV-mapped file
    pub file: PathBuf,
    /// Which set of UVs: TEXCOORD_N of a glTF, texcoordN of a PLY
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=15))]
    pub uv_set: u32,
    /// The picture to write
    #[arg(short, long, value_name = "SHEET.png")]
    pub output: PathBuf,
}
