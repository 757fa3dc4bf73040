//! A map of a cut surface that is to be learned, or was: how, where it is kept, and what came of it.

use super::report::UnwrapError;
use crate::learn::chart_net::ChartNet;
use crate::learn::fit::{FitSample, FitSettings};
use crate::solve::modes::MODES;
use glam::DVec2;

/// Charts that one network learns at the most: the largest. Others stay as the exact stages made them.
pub const MOST_CHARTS: usize = 32;
/// Features of a node beside its chart's number: place, normal, modes.
const FEATURES: usize = 3 + 3 + MODES;

/// The network for `charts` charts.
pub const fn net_of(settings: &FitSettings, charts: usize) -> ChartNet {
    let slots = if charts < MOST_CHARTS { charts } else { MOST_CHARTS };
    ChartNet { widths: settings.widths, features: FEATURES + slots }
}

/// A learned map: with the mesh it was learned of, all that its UVs come from.
pub struct LearnedMap<'a> {
    /// Weights of the network, each a number that 16 bits hold; those of fewer charts than [`MOST_CHARTS`] are fewer.
    pub weights: &'a mut [f32], // (parameters of MOST_CHARTS)
    /// Whether each half-edge of the working mesh is cut.
    pub cut: &'a mut [u8], // (3 f)
    /// UVs at the corners of the working mesh that are not the network's; NaN elsewhere.
    pub corrected: &'a mut [DVec2], // (3 f)
}

/// What to learn, and where it is kept.
pub struct Fitting<'a> {
    /// How to learn it.
    pub settings: FitSettings,
    /// The map. Its lists may be longer than is needed: as long as the mesh of polygons has triangles will do.
    pub map: LearnedMap<'a>,
    /// Whether the map is given, and only evaluated: of a mesh other than that it was learned of, nothing good comes.
    pub is_given: bool,
    /// Samples of the objective; any length.
    pub curve: &'a mut [FitSample],
    /// How it went.
    pub summary: FitSummary,
}

impl Fitting<'_> {
    /// Whether there is room for the map of `triangles` triangles.
    pub(super) fn check(&self, triangles: usize) -> Result<(), UnwrapError> {
        let LearnedMap { weights, cut, corrected } = &self.map;
        let needs = [
            (weights.len(), net_of(&self.settings, MOST_CHARTS).parameter_count()),
            (cut.len(), 3 * triangles),
            (corrected.len(), 3 * triangles),
        ];
        match needs.into_iter().find(|(given, expected)| given < expected) {
            Some((given, expected)) => Err(UnwrapError::BadLength { expected, given }),
            None => Ok(()),
        }
    }
}

/// What was learned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitSummary {
    /// Charts that the network maps; those of copies, which have the charts of another piece, do not count.
    pub charts: usize,
    /// Faces that it maps, with those of copies, and all of those that were to be mapped.
    pub faces: [usize; 2],
    /// Nodes (wedges) that it maps.
    pub nodes: usize,
    /// Steps.
    pub steps: usize,
    /// Samples in the curve.
    pub samples: usize,
    /// Whether training was stopped before its end.
    pub was_stopped: bool,
    /// The network's own map, before anything else was done to it.
    pub own: OwnFigures,
    /// Nodes that were moved afterwards.
    pub moved_nodes: usize,
    /// How far half of the nodes, one in twenty and one in a hundred were moved at the least, over the square root of the area that
    /// all charts have together.
    pub moved: [f64; 3],
}

/// Figures of the map as the network gives it. Means are over faces, the distortion is over the area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnFigures {
    /// Mean symmetric Dirichlet energy over 4, after the best scale, without faces that have next to no area in UV.
    pub distortion: f64,
    /// 1 - mean error of angles, in radians.
    pub conformality: f64,
    /// 1 - mean error of the logarithm of areas.
    pub equiareality: f64,
    /// Faces that are turned over.
    pub flipped: usize,
}
