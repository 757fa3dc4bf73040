//! The words of `transfer`.

use super::run::RunArgs;
use super::writing::WritingArgs;
use clap::Args;
use std::path::PathBuf;

/// `transfer`.
#[derive(Debug, Args)]
pub struct TransferArgs {
    /// A mesh with the atlas that is wanted
    pub source: PathBuf,
    /// A mesh of the same shape in the same place: a level of detail, a remesh, a subdivision, an edit
    pub mesh: PathBuf,
    /// What is written.
    #[command(flatten)]
    pub writing: WritingArgs,
    /// Side of the texture, by which the report counts texels
    #[arg(long, value_name = "TEXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub size: u32,
    /// Also draw the result
    #[arg(long, value_name = "OUT.png")]
    pub sheet: Option<PathBuf>,
    /// Also write a report; - is standard output
    #[arg(long, value_name = "REPORT.json|-")]
    pub json: Option<PathBuf>,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}
