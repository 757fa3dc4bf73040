//! Settings of training, from a preset, a file and flags, in this order.
//!
//! The file is TOML: the keys of `SettingsFile`, and a table `weights` with a key for each loss. Unknown keys are refused with
//! file and line.

use super::trainer::{FitTrainer, PublishedTrainer, Trainer, WIDEST};
use crate::args::learning::LearningArgs;
use crate::base::failure::Failure;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::fit::FitSettings;
use seamwright_core::learn::losses::Loss;
use seamwright_core::learn::training::TrainSettings;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The preset that is the published training.
pub const PAPER: &str = "paper";

/// The settings file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsFile {
    preset: Option<String>,
    width: Option<usize>,
    code: Option<usize>,
    steps: Option<usize>,
    first_rate: Option<f64>,
    // The published training's alone.
    batch: Option<usize>,
    side: Option<f64>,
    spread: Option<f64>,
    margin: Option<f64>,
    last_rate: Option<f64>,
    weights: Option<BTreeMap<toml::Spanned<String>, f64>>,
}

impl SettingsFile {
    /// A key that only the published training knows.
    fn published_key(&self) -> Option<&'static str> {
        let given = [
            ("batch", self.batch.is_some()),
            ("side", self.side.is_some()),
            ("spread", self.spread.is_some()),
            ("margin", self.margin.is_some()),
            ("last_rate", self.last_rate.is_some()),
            ("weights", self.weights.is_some()),
        ];
        given.into_iter().find(|(_, is_given)| *is_given).map(|(key, _)| key)
    }
}

impl Trainer {
    /// The preset with the file's and the flags' changes.
    pub fn new(args: &LearningArgs, seed: u64) -> Result<Self, Failure> {
        let text = match &args.file {
            Some(path) => std::fs::read_to_string(path).map_err(|e| Failure::input(path, &e))?,
            None => String::new(),
        };
        let path = args.file.as_deref().unwrap_or(Path::new("--settings"));
        let file: SettingsFile = toml::from_str(&text).map_err(|e| {
            let line = e.span().map_or(1, |span| line_of(&text, span.start));
            let what = e.message().lines().next().unwrap_or("not TOML").to_string();
            Failure::Usage(format!("--settings {}:{line}: {what}; see docs/FORMATS.md", path.display()))
        })?;
        let wrong = |line: usize, text: String| {
            let line = if line == 0 { String::new() } else { format!(":{line}") };
            Failure::Usage(format!("--settings {}{line}: {text}", path.display()))
        };
        let preset = args.preset.clone().or(file.preset.clone()).unwrap_or_else(|| "standard".into());
        let steps = args.steps.map(|s| s as usize).or(file.steps);
        let in_range = |widths: Widths, steps: usize| {
            let is_width = |x: usize| (1..=WIDEST).contains(&x);
            let all = is_width(widths.hidden) && is_width(widths.code) && steps > 0;
            if all { Ok(()) } else { Err(wrong(0, format!("width and code must be 1 to {WIDEST}, steps 1 or more"))) }
        };
        if preset != PAPER {
            let mut settings = FitSettings::preset(&preset)
                .ok_or_else(|| wrong(0, format!("preset {preset:?}; write \"draft\", \"standard\" or \"paper\"")))?;
            if let Some(key) = file.published_key() {
                return Err(wrong(0, format!("{key} is of the published training; add preset = \"paper\"")));
            }
            if args.visibility.is_some() {
                let text = "only the published training has that loss; add --preset paper, or leave it out: seams hide by --prefer";
                return Err(Failure::Usage(format!("--visibility: {text}")));
            }
            let Widths { hidden, code } = settings.widths;
            settings.widths = Widths { hidden: file.width.unwrap_or(hidden), code: file.code.unwrap_or(code) };
            settings.steps = steps.unwrap_or(settings.steps);
            settings.rate = file.first_rate.unwrap_or(settings.rate);
            settings.seed = seed;
            in_range(settings.widths, settings.steps)?;
            if !(settings.rate.is_finite() && settings.rate >= 0.0) {
                return Err(wrong(0, "first_rate must be a number, 0 or more".into()));
            }
            return Ok(Self::Fit(Box::new(FitTrainer::new(preset, settings))));
        }
        let mut settings = TrainSettings::PAPER;
        let Widths { hidden, code } = settings.widths;
        settings.widths = Widths { hidden: file.width.unwrap_or(hidden), code: file.code.unwrap_or(code) };
        settings.steps = steps.unwrap_or(settings.steps);
        settings.batch = file.batch.unwrap_or(settings.batch);
        settings.side = file.side.unwrap_or(settings.side);
        settings.spread = file.spread.unwrap_or(settings.spread);
        settings.margin = file.margin.unwrap_or(settings.margin);
        settings.rate = [file.first_rate.unwrap_or(settings.rate[0]), file.last_rate.unwrap_or(settings.rate[1])];
        settings.seed = seed;
        for (name, weight) in file.weights.iter().flatten() {
            let Some(loss) = Loss::ALL.into_iter().find(|loss| loss.name() == name.get_ref()) else {
                let known: Vec<_> = Loss::ALL.iter().map(|loss| loss.name()).collect();
                let what = format!("weights: no loss is called {}; there are {}", name.get_ref(), known.join(", "));
                return Err(wrong(line_of(&text, name.span().start), what));
            };
            settings.weights = settings.weights.with(loss, *weight);
        }
        if let Some(weight) = args.visibility {
            settings.weights = settings.weights.with(Loss::Visibility, weight);
        }
        in_range(settings.widths, settings.steps)?;
        let numbers = [settings.side, settings.spread, settings.margin, settings.rate[0], settings.rate[1]];
        if !numbers.iter().chain(&settings.weights.0).all(|x| x.is_finite() && *x >= 0.0) {
            return Err(wrong(0, "weights, rates, side, spread and margin must be numbers, 0 or more".into()));
        }
        if args.save_map.is_some() {
            let text = "maps of the published training are not kept; take another preset";
            return Err(Failure::Usage(format!("--save-map: {text}")));
        }
        Ok(Self::Published(Box::new(PublishedTrainer::new(settings))))
    }
}

fn line_of(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|b| *b == b'\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn read(text: &str) -> Result<Trainer, Failure> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        let args = LearningArgs { file: Some(file.path().into()), steps: Some(7), ..LearningArgs::default() };
        Trainer::new(&args, 3)
    }

    #[test]
    fn flags_win_over_the_file_and_the_file_over_the_preset() {
        let Trainer::Fit(fit) = read("preset = \"draft\"\nsteps = 5\nwidth = 20\n").unwrap() else { panic!("a fit") };
        assert_eq!(fit.settings.widths, Widths { hidden: 20, code: FitSettings::DRAFT.widths.code });
        assert_eq!((fit.settings.steps, fit.settings.seed), (7, 3));
        let paper = read("preset = \"paper\"\nsteps = 5\nbatch = 9\n[weights]\nfold = 0.5\n").unwrap();
        let Trainer::Published(paper) = paper else { panic!("the published training") };
        assert_eq!((paper.settings.steps, paper.settings.batch), (7, 9));
        assert_eq!(paper.settings.weights, TrainSettings::PAPER.weights.with(Loss::Fold, 0.5));
    }

    #[test]
    fn what_is_unknown_or_out_of_range_is_refused_with_its_line() {
        for (text, line, word) in [
            ("width = 8\nwidht = 8\n", ":2:", "widht"),
            ("preset = \"paper\"\nsteps = 3\n\n[weights]\nfold = 1.0\nfolds = 1.0\n", ":6:", "folds"),
            ("steps = \"many\"\n", ":1:", "invalid type"),
            ("width = 0\n", "", "width"),
            ("preset = \"fast\"\n", "", "fast"),
            ("batch = 3\n", "", "paper"),
            ("first_rate = -1.0\n", "", "0 or more"),
            ("preset = \"paper\"\n[weights]\nfold = -1.0\n", "", "0 or more"),
        ] {
            let Err(Failure::Usage(message)) = read(text) else { panic!("{text} was taken") };
            assert!(message.contains(line) && message.contains(word), "{text}: {message}");
        }
    }
}
