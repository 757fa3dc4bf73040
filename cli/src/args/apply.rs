//! The words of `apply`.

use super::run::RunArgs;
use super::settings::SettingsArgs;
use super::writing::WritingArgs;
use clap::Args;
use std::path::PathBuf;

/// `apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// The mesh that the map was learned of
    pub mesh: PathBuf,
    /// A map that `unwrap --save-map` wrote
    #[arg(long, value_name = "FILE")]
    pub map: PathBuf,
    /// What is written.
    #[command(flatten)]
    pub writing: WritingArgs,
    /// How the atlas is made.
    #[command(flatten)]
    pub settings: SettingsArgs,
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
