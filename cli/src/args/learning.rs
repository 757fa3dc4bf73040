//! How maps are trained, as asked.

use clap::Args;
use seamwright_core::learn::fit::FitSettings;
use std::path::PathBuf;

/// How maps are learned (`neural`).
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Learning (--method neural)")]
pub struct LearningArgs {
    /// How a map is learned: draft, standard or paper (the published training). standard by default
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub preset: Option<String>,
    /// A file that changes the preset's settings (see docs/FORMATS.md)
    #[arg(long = "settings", value_name = "FILE.toml")]
    pub file: Option<PathBuf>,
    /// Steps of training
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub steps: Option<u32>,
    /// Weight of the published loss that draws seams to hidden places, with --preset paper; 0 turns it off
    #[arg(long, value_name = "WEIGHT", value_parser = weight)]
    pub visibility: Option<f64>,
    /// Also write the learned map, for `seamwright apply`
    #[arg(long, value_name = "FILE")]
    pub save_map: Option<PathBuf>,
    /// Also draw the objective over the steps
    #[arg(long, value_name = "OUT.png")]
    pub curves: Option<PathBuf>,
}

fn preset(word: &str) -> Result<String, String> {
    let is_known = word == "paper" || FitSettings::preset(word).is_some();
    if is_known { Ok(word.to_string()) } else { Err("write draft, standard or paper".into()) }
}

fn weight(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(weight) if weight >= 0.0 && weight.is_finite() => Ok(weight),
        _ => Err("write a number, 0 or more".into()),
    }
}
