//! Parts of an object: a label a face, by the method and for the number of parts that the caller asks for.
//!
//! [`Count::Auto`] and [`Count::Exactly`] cut along concave borders between regions that see each other badly through
//! the object's inside (see `merging`); [`Count::Published`] is the mixture of shape diameters with graph cuts (see
//! `published`), kept for comparison.
//! Rays belong to another stage, so what they find comes in: the shape diameter of each face and a function that says
//! whether two points see each other. `pipeline::partition` puts both together.
//! Every label is one connected region of faces; labels are 0..count, in the order of their lowest faces. Components of
//! the mesh never share a label.

use super::by_sight::{by_sight, by_sight_need};
use super::dual::{Dual, dual_need};
use super::published::{published, published_need};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::mesh::view::MeshView;
use glam::Vec3;

/// How many parts, and by which method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Count {
    /// As many as the shape has.
    #[default]
    Auto,
    /// This many over the whole mesh, where it has at least as many faces; never fewer than its components.
    Exactly(u32),
    /// The published method. Its parts are the connected regions of clusters, so there are at least as many.
    Published {
        /// Clusters of shape diameters, 1 to 16; None: as many as the Bayesian information criterion wants.
        clusters: Option<u32>,
        /// Weight of smoothness, at least 0.
        lambda: f64,
    },
}

impl Count {
    /// The published method with its published numbers.
    pub const PUBLISHED: Count = Count::Published { clusters: Some(3), lambda: 15.0 };
}

/// What can be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Number of parts and method.
    pub count: Count,
    /// Seed of every random value.
    pub seed: u64,
}

/// What is cut into parts.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Oriented manifold triangles, as from `repair`.
    pub mesh: MeshView<'a>,
    /// Their twins.
    pub twin: &'a [u32], // (3 f)
    /// Shape diameter of each face, in the mesh's units.
    pub diameter: &'a [f32], // (f)
    /// Whether the straight way from the first to the second point meets no face.
    pub sees: &'a (dyn Fn(Vec3, Vec3) -> bool + Sync),
}

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Parts; labels are 0..parts.
    pub parts: usize,
    /// Clusters of the published method, else 0.
    pub clusters: usize,
}

/// Scratch bytes that [`parts`] asks for.
pub const fn parts_need(faces: usize, vertices: usize) -> usize {
    let _ = vertices;
    let (a, b) = (by_sight_need(faces), published_need(faces));
    dual_need(faces) + if a > b { a } else { b }
}

/// Fills `labels`. Near-linear in the number of faces.
pub fn parts(
    labels: &mut [u32], // (f)
    surface: &Surface,
    settings: &Settings,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Summary, ScratchTooSmall> {
    scratch.require(parts_need(surface.mesh.faces.len(), surface.mesh.positions.len()))?;
    if labels.is_empty() {
        return Ok(Summary::default());
    }
    let dual = Dual::new(surface.mesh, surface.twin, &mut scratch)?;
    match settings.count {
        Count::Published { clusters, lambda } => published(labels, surface, &dual, clusters, lambda, scratch),
        Count::Auto => by_sight(labels, surface, &dual, None, scratch, workers),
        Count::Exactly(n) => by_sight(labels, surface, &dual, Some(n as usize), scratch, workers),
    }
}
