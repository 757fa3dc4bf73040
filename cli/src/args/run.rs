//! How a run behaves, as asked.

use clap::Args;

/// How a run behaves.
#[derive(Clone, Copy, Debug, Args)]
pub struct RunArgs {
    /// Threads; as many as the machine runs at once by default. The result does not depend on it
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}
