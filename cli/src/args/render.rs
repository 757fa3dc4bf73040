//! The words of `render`.

use clap::Args;
use std::path::PathBuf;

/// `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A UV-mapped OBJ file
    #[arg(value_name = "FILE.obj")]
    pub file: PathBuf,
    /// The picture to write
    #[arg(short, long, value_name = "SHEET.png")]
    pub output: PathBuf,
}
