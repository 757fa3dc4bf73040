//! How maps were learned, for the report.

use crate::training::settings::PAPER;
use crate::training::trainer::{FitTrainer, PublishedTrainer, Trainer};
use seamwright_core::learn::losses::Loss;
use seamwright_core::pipeline::Report;
use serde::Serialize;
use std::collections::BTreeMap;

/// Texels a side in which movements are told.
const TEXELS: f64 = 1024.0;

/// How maps were learned.
#[derive(Debug, Serialize)]
pub struct LearningReport {
    /// Name of the preset; `given` where the map came from a file.
    pub preset: String,
    /// Width of hidden layers.
    pub width: usize,
    /// Width of codes.
    pub code: usize,
    /// Steps that were made.
    pub steps: usize,
    /// Whether training was stopped before its end.
    pub was_stopped: bool,
    /// The map of charts, where one was learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapReport>,
    /// The published training.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<PublishedReport>,
    /// Steps at which the objective was looked at.
    pub curve_steps: Vec<usize>,
    /// Its terms at these steps, unweighted; `visibility` is the exposure of seams.
    pub curves: BTreeMap<&'static str, Vec<f32>>,
}

/// What a network learned of charts, and what was done to its map.
#[derive(Debug, Serialize)]
pub struct MapReport {
    /// Charts that it maps.
    pub charts: usize,
    /// Faces that it maps.
    pub faces: usize,
    /// Faces beyond those that one network learns, as the exact stages made them.
    pub other_faces: usize,
    /// Points that it maps: vertices, of which the sides of seams are different ones.
    pub points: usize,
    /// Mean symmetric Dirichlet energy over 4 of its own map, before anything was done to it.
    pub own_distortion: f64,
    /// 1 - mean error of angles of its own map, radians.
    pub own_conformality: f64,
    /// 1 - mean error of the logarithm of areas of its own map.
    pub own_equiareality: f64,
    /// Faces that its own map turns over.
    pub own_flipped: usize,
    /// Points that were moved afterwards.
    pub moved_points: usize,
    /// How far half of all points, one in twenty and one in a hundred were moved at the least, in texels of an atlas of 1024.
    pub moved_texels: [f64; 3],
}

/// What belongs to the published training alone.
#[derive(Debug, Serialize)]
pub struct PublishedReport {
    /// Points of a batch; 0 is all.
    pub batch: usize,
    /// Weight of each loss.
    pub weights: BTreeMap<&'static str, f64>,
    /// Maps that were trained.
    pub maps: usize,
    /// Faces that a map tears or folds and that were laid down beside others.
    pub torn_faces: usize,
    /// Faces that a map turns over.
    pub folded_faces: usize,
}

impl LearningReport {
    /// What `trainer` was asked and did, on the way to the atlas of `report`.
    pub fn new(trainer: &Trainer, report: &Report) -> Self {
        let curves = trainer.curves();
        let (preset, widths) = match trainer {
            Trainer::Fit(fit) => (fit.preset.clone(), fit.settings.widths),
            Trainer::Published(published) => (PAPER.to_string(), published.settings.widths),
        };
        let (map, published) = match trainer {
            // A given map is no news.
            Trainer::Fit(fit) => (fit.given.is_none().then(|| MapReport::new(fit, report)), None),
            Trainer::Published(published) => (None, Some(PublishedReport::new(published))),
        };
        Self {
            preset,
            width: widths.hidden,
            code: widths.code,
            steps: trainer.steps(),
            was_stopped: trainer.was_stopped(),
            map,
            published,
            curve_steps: curves.steps,
            curves: curves.terms.into_iter().collect(),
        }
    }
}

impl MapReport {
    fn new(fit: &FitTrainer, report: &Report) -> Self {
        let summary = &fit.summary;
        let own = &summary.own;
        Self {
            charts: summary.charts,
            faces: summary.faces[0],
            other_faces: summary.faces[1] - summary.faces[0],
            points: summary.nodes,
            own_distortion: own.distortion,
            own_conformality: own.conformality,
            own_equiareality: own.equiareality,
            own_flipped: own.flipped,
            moved_points: summary.moved_nodes,
            moved_texels: summary.moved.map(|far| far * report.utilisation.sqrt() * TEXELS),
        }
    }
}

impl PublishedReport {
    fn new(trainer: &PublishedTrainer) -> Self {
        let (settings, summary) = (&trainer.settings, trainer.summary);
        Self {
            batch: settings.batch,
            weights: Loss::ALL.into_iter().map(|l| (l.name(), settings.weights.0[l as usize])).collect(),
            maps: summary.maps,
            torn_faces: summary.torn.faces,
            folded_faces: summary.torn.folded,
        }
    }
}
