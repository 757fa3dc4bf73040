//! The words of `batch`.

use super::group::GroupArg;
use super::settings::SettingsArgs;
use super::writing::UvSetArgs;
use clap::Args;
use std::path::PathBuf;

/// `batch`.
#[derive(Debug, Args)]
pub struct BatchArgs {
    /// Meshes, folders of meshes, and lists of both (.txt, a path a line)
    #[arg(required = true, value_name = "IN")]
    pub inputs: Vec<PathBuf>,
    /// Folder to write to, laid out as the folders that came in; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Files at once, as far as memory allows; as many as the machine runs threads by default
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Seconds after which a file is given up
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub timeout: Option<f64>,
    /// Which share of the files, from 0; see --world-size
    #[arg(long, value_name = "R", default_value_t = 0)]
    pub rank: u32,
    /// Into how many shares the files are dealt, one for each machine
    #[arg(long, value_name = "W", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub world_size: u32,
    /// Skip files that were done with these settings and have not changed; their lines are printed again
    #[arg(long)]
    pub resume: bool,
    /// What shares an atlas, a unit square of its own
    #[arg(long, value_enum, default_value_t = GroupArg::Scene)]
    pub group: GroupArg,
    /// The UVs among others.
    #[command(flatten)]
    pub set: UvSetArgs,
    /// Keep the borders of the UVs that a file has as cuts
    #[arg(long)]
    pub keep_seams: bool,
    /// How atlases are made.
    #[command(flatten)]
    pub settings: SettingsArgs,
}

fn seconds(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds < 1e9 => Ok(seconds),
        _ => Err("write a number of seconds above 0".into()),
    }
}
