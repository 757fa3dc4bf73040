//! What is written, as asked.

use clap::Args;
use std::path::PathBuf;

/// Endings, as --format takes them.
pub(super) const FORMATS: [&str; 7] = ["obj", "ply", "stl", "off", "glb", "gltf", "fbx"];

/// What is written.
#[derive(Clone, Debug, Args)]
pub struct WritingArgs {
    /// The mesh to write: .obj, .ply, .glb or .gltf. Of the format that came in, everything but the UVs stays as it was. May
    /// be the input itself; - is standard output
    #[arg(short, long, value_name = "OUT|-")]
    pub output: PathBuf,
    /// What - is, as mesh (standard input) or as -o (standard output)
    #[arg(long, value_name = "FORMAT", value_parser = FORMATS)]
    pub format: Option<String>,
    /// The UVs among others.
    #[command(flatten)]
    pub set: UvSetArgs,
    /// Write an .off, which holds no UVs a corner
    #[arg(long)]
    pub without_uvs: bool,
}

/// Which of a file's sets of UVs is meant.
#[derive(Clone, Debug, Args)]
pub struct UvSetArgs {
    /// Which set of UVs is written, and read where UVs are kept: TEXCOORD_N of a glTF, texcoordN of a PLY. Other sets stay
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=15))]
    pub uv_set: u32,
    /// Keep the UVs that this set has as another set, which the materials of a glTF then take
    #[arg(long)]
    pub keep: bool,
}
