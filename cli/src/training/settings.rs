//! Settings of training, from a preset, a file and flags, in this order.
//!
//! The file is TOML: the keys of `SettingsFile`, and a table `weights` with a key for each loss. Unknown keys are refused with
//! file and line.

use super::trainer::{Trainer, WIDEST};
use crate::args::learning::LearningArgs;
use crate::base::failure::Failure;
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::losses::Loss;
use seamwright_core::learn::training::TrainSettings;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The settings file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsFile {
    preset: Option<String>,
    width: Option<usize>,
    code: Option<usize>,
    steps: Option<usize>,
    batch: Option<usize>,
    side: Option<f64>,
    spread: Option<f64>,
    margin: Option<f64>,
    first_rate: Option<f64>,
    last_rate: Option<f64>,
    start: Option<bool>,
    weights: Option<BTreeMap<toml::Spanned<String>, f64>>,
}

impl Trainer {
    /// The preset with the file's and the flags' changes. `paper` starts from random weights, the others from charts.
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
        let preset = args.preset.clone().or(file.preset).unwrap_or_else(|| "standard".into());
        let mut settings = TrainSettings::preset(&preset)
            .ok_or_else(|| wrong(0, format!("preset {preset:?}; write \"draft\", \"standard\" or \"paper\"")))?;
        let Widths { hidden, code } = settings.widths;
        settings.widths = Widths { hidden: file.width.unwrap_or(hidden), code: file.code.unwrap_or(code) };
        settings.steps = args.steps.map(|s| s as usize).or(file.steps).unwrap_or(settings.steps);
        settings.batch = file.batch.unwrap_or(settings.batch);
        settings.side = file.side.unwrap_or(settings.side);
        settings.spread = file.spread.unwrap_or(settings.spread);
        settings.margin = file.margin.unwrap_or(settings.margin);
        settings.rate = [file.first_rate.unwrap_or(settings.rate[0]), file.last_rate.unwrap_or(settings.rate[1])];
        settings.seed = seed;
        for (name, weight) in file.weights.iter().flatten() {
            let Some(loss) = Loss::ALL.into_iter().find(|loss| loss.name() == name.get_ref()) else {
                let known: Vec<_> = Loss::ALL.iter().map(|loss| loss.name()).collect();
                let text = format!("weights: no loss is called {}; there are {}", name.get_ref(), known.join(", "));
                return Err(wrong(line_of(&text_of(args)?, name.span().start), text));
            };
            settings.weights = settings.weights.with(loss, *weight);
        }
        if let Some(weight) = args.visibility {
            settings.weights = settings.weights.with(Loss::Visibility, weight);
        }
        let Widths { hidden, code } = settings.widths;
        let in_range = |x: usize| (1..=WIDEST).contains(&x);
        if !in_range(hidden) || !in_range(code) || settings.steps == 0 {
            return Err(wrong(0, format!("width and code must be 1 to {WIDEST}, steps 1 or more")));
        }
        let numbers = [settings.side, settings.spread, settings.margin, settings.rate[0], settings.rate[1]];
        if !numbers.iter().chain(&settings.weights.0).all(|x| x.is_finite() && *x >= 0.0) {
            return Err(wrong(0, "weights, rates, side, spread and margin must be numbers, 0 or more".into()));
        }
        let start = file.start.unwrap_or(preset != "paper");
        Ok(Self::with(preset, settings, start))
    }
}

fn text_of(args: &LearningArgs) -> Result<String, Failure> {
    args.file
        .as_ref()
        .map_or(Ok(String::new()), |path| std::fs::read_to_string(path).map_err(|e| Failure::input(path, &e)))
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
        let trainer = read("preset = \"draft\"\nsteps = 5\nwidth = 20\n[weights]\nfold = 0.5\n").unwrap();
        let expected = TrainSettings { steps: 7, seed: 3, ..TrainSettings::DRAFT };
        assert_eq!(trainer.settings.widths, Widths { hidden: 20, code: TrainSettings::DRAFT.widths.code });
        assert_eq!((trainer.settings.steps, trainer.settings.seed), (expected.steps, expected.seed));
        assert_eq!(trainer.settings.weights, expected.weights.with(Loss::Fold, 0.5));
        assert!(trainer.start && !read("preset = \"paper\"").unwrap().start);
    }

    #[test]
    fn what_is_unknown_or_out_of_range_is_refused_with_its_line() {
        for (text, line, word) in [
            ("width = 8\nwidht = 8\n", ":2:", "widht"),
            ("steps = 3\n\n[weights]\nfold = 1.0\nfolds = 1.0\n", ":5:", "folds"),
            ("steps = \"many\"\n", ":1:", "invalid type"),
            ("width = 0\n", "", "width"),
            ("preset = \"fast\"\n", "", "fast"),
            ("[weights]\nfold = -1.0\n", "", "0 or more"),
        ] {
            let Err(Failure::Usage(message)) = read(text) else { panic!("{text} was taken") };
            assert!(message.contains(line) && message.contains(word), "{text}: {message}");
        }
    }
}
