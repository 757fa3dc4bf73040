//! What core needs to learn maps, and what is left of it.

use glam::DVec2;
use seamwright_core::learn::fit::{FitSample, FitSettings, TERM_NAMES};
use seamwright_core::learn::losses::Loss;
use seamwright_core::learn::training::{Sample, TrainSettings};
use seamwright_core::pipeline::fitting::{FitSummary, Fitting, LearnedMap, MOST_CHARTS, net_of};
use seamwright_core::pipeline::learning::{LearnedSummary, Learning, MOST};

/// Points of the curves at the most.
const SAMPLES: usize = 200;
/// Widest network that a settings file or a map may ask for.
pub const WIDEST: usize = 1024;

/// How maps are learned, and what is left of it.
#[derive(Clone, Debug)]
pub enum Trainer {
    /// A map of the exact stages' charts.
    Fit(Box<FitTrainer>),
    /// The published training.
    Published(Box<PublishedTrainer>),
}

/// A map of charts.
#[derive(Clone, Debug)]
pub struct FitTrainer {
    /// The preset's name; `given` where the map is.
    pub preset: String,
    /// Widths, steps, rate and seed.
    pub settings: FitSettings,
    /// The mesh that the given map was learned of, as [`super::map_file::mesh_hash`] knows it; none where it is yet to be learned.
    pub given: Option<u64>,
    /// Weights of the network.
    pub weights: Vec<f32>,
    /// Whether each half-edge of the working mesh is cut.
    pub cut: Vec<u8>, // (3 f)
    /// UVs at corners of the working mesh that are not the network's; NaN elsewhere.
    pub corrected: Vec<DVec2>, // (3 f)
    /// The objective over the steps.
    pub curve: Vec<FitSample>,
    /// How it went.
    pub summary: FitSummary,
}

impl FitTrainer {
    /// Before a map is learned.
    pub fn new(preset: String, settings: FitSettings) -> Self {
        Self {
            preset,
            settings,
            given: None,
            weights: vec![0.0; net_of(&settings, MOST_CHARTS).parameter_count()],
            cut: Vec::new(),
            corrected: Vec::new(),
            curve: vec![FitSample::default(); SAMPLES],
            summary: FitSummary::default(),
        }
    }

    /// As core takes it, for a mesh of so many triangles at the most.
    pub fn fitting(&mut self, triangles: usize) -> Fitting<'_> {
        self.cut.resize(self.cut.len().max(3 * triangles), 0);
        self.corrected.resize(self.corrected.len().max(3 * triangles), DVec2::NAN);
        let map = LearnedMap { weights: &mut self.weights, cut: &mut self.cut, corrected: &mut self.corrected };
        let (settings, is_given, summary) = (self.settings, self.given.is_some(), FitSummary::default());
        Fitting { settings, map, is_given, curve: &mut self.curve, summary }
    }
}

/// The published training.
#[derive(Clone, Debug)]
pub struct PublishedTrainer {
    /// Widths, steps, weights and the rest.
    pub settings: TrainSettings,
    /// Weights of the maps.
    pub weights: Vec<f32>, // (MOST, parameters)
    /// Losses of the largest piece.
    pub curve: Vec<Sample>,
    /// How it went.
    pub summary: LearnedSummary,
}

impl PublishedTrainer {
    /// Room for maps of these settings.
    pub fn new(settings: TrainSettings) -> Self {
        let weights = vec![0.0; MOST * settings.widths.parameter_count()];
        Self { settings, weights, curve: vec![Sample::default(); SAMPLES], summary: LearnedSummary::default() }
    }

    /// As core takes it.
    pub fn learning(&mut self) -> Learning<'_> {
        let (settings, summary) = (self.settings, LearnedSummary::default());
        Learning { settings, weights: &mut self.weights, curve: &mut self.curve, summary }
    }
}

/// Terms of an objective over the steps.
#[derive(Debug, Default)]
pub struct Curves {
    /// Steps at which they were looked at.
    pub steps: Vec<usize>,
    /// Each term's name, and its values there, unweighted.
    pub terms: Vec<(&'static str, Vec<f32>)>,
}

impl Trainer {
    /// Steps that were made.
    pub fn steps(&self) -> usize {
        match self {
            Trainer::Fit(fit) => fit.summary.steps,
            Trainer::Published(published) => published.summary.steps,
        }
    }

    /// Whether training was stopped before its end.
    pub fn was_stopped(&self) -> bool {
        match self {
            Trainer::Fit(fit) => fit.summary.was_stopped,
            Trainer::Published(published) => published.summary.was_stopped,
        }
    }

    /// The terms of the objective that were on.
    pub fn curves(&self) -> Curves {
        match self {
            Trainer::Fit(fit) => {
                let samples = &fit.curve[..fit.summary.samples];
                let term = |(i, name): (usize, &&'static str)| (*name, samples.iter().map(|s| s.terms[i]).collect());
                Curves {
                    steps: samples.iter().map(|s| s.step).collect(),
                    terms: TERM_NAMES.iter().enumerate().map(term).collect(),
                }
            }
            Trainer::Published(published) => {
                let samples = &published.curve[..published.summary.samples];
                let on = |loss: &Loss| published.settings.weights.0[*loss as usize] != 0.0;
                let term = |loss: Loss| (loss.name(), samples.iter().map(|s| s.losses[loss as usize]).collect());
                Curves {
                    steps: samples.iter().map(|s| s.step).collect(),
                    terms: Loss::ALL.into_iter().filter(on).map(term).collect(),
                }
            }
        }
    }
}
