//! The words of `demo`.

use super::run::RunArgs;
use clap::Args;
use std::path::PathBuf;

/// `demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "seamwright-demo")]
    pub output: PathBuf,
    /// How it runs.
    #[command(flatten)]
    pub run: RunArgs,
}
