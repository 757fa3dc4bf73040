//! What a bound on distortion means: the mean over the surface, and the cap on its single faces.
//!
//! Faces of no area to speak of count for neither: their shape is a matter of rounding.

use super::energy::Rest;
use crate::base::real::sqrt;
use glam::DVec2;

/// A face below this share of the mean area has none to speak of.
const FLAT: f64 = 1e-9;
/// Most that the energy over 4 of a single face may be above 1, over what the bound allows on the mean.
const CAP: f64 = 40.0;
/// The cap on single faces at tight bounds: a mesh has corners that are never flat.
const LEAST_CAP: f64 = 1.5;

/// Mean energy over 4, less 1, up to which a chart counts as without distortion.
const AT_EASE: f64 = 1e-4;

/// Most symmetric Dirichlet energy over 4 of a single face where `bound` holds on the mean: 2 at 1.025.
pub fn most_distorted(bound: f64) -> f64 {
    (1.0 + CAP * (bound - 1.0)).max(LEAST_CAP)
}

/// Symmetric Dirichlet energy of each face that has an area to speak of, at the scale that the map has.
pub fn energies(uv: &[DVec2], rest: &[Rest]) -> impl Iterator<Item = (usize, f64)> {
    let flat = flat_area(rest);
    let faces = rest.iter().enumerate().filter(move |(_, r)| r.area > flat);
    faces.map(|(f, r)| (f, r.energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]])))
}

/// The largest of [`energies`].
pub fn worst(uv: &[DVec2], rest: &[Rest]) -> f64 {
    energies(uv, rest).map(|(_, energy)| energy).fold(4.0, f64::max)
}

/// Area up to which a face has none to speak of.
pub fn flat_area(rest: &[Rest]) -> f64 {
    FLAT * rest.iter().map(|r| r.area).sum::<f64>() / rest.len().max(1) as f64
}

/// Whether `faces` lie in the plane as they are in space, but for what a map that is not at rest leaves.
pub fn lie_flat(faces: &[u32], uv: &[DVec2], rest: &[Rest]) -> bool {
    let (mut area, mut energy) = (0.0, 0.0);
    for f in faces.iter().map(|f| *f as usize) {
        area += rest[f].area;
        energy += rest[f].area * rest[f].energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]);
    }
    energy <= 4.0 * area * (1.0 + AT_EASE)
}

/// Sums over the faces that have an area to speak of.
#[derive(Clone, Copy, Debug, Default)]
pub struct Strain {
    /// Area times the squared norm of the Jacobian.
    pub stretch: f64,
    /// The same of its inverse.
    pub shrink: f64,
    /// Area.
    pub area: f64,
}

impl Strain {
    /// Of a map at the scale that it has.
    pub fn of(uv: &[DVec2], rest: &[Rest]) -> Self {
        let mut sum = Self::default();
        let flat = flat_area(rest);
        for (f, rest) in rest.iter().enumerate().filter(|(_, r)| r.area > flat) {
            sum.add(rest, [uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]);
        }
        sum
    }

    /// Adds a face.
    pub fn add(&mut self, rest: &Rest, corners: [DVec2; 3]) {
        let [c0, c1] = rest.jacobian(corners);
        let (det, norm) = (c0.perp_dot(c1), c0.dot(c0) + c1.dot(c1));
        self.stretch += rest.area * norm;
        self.shrink += rest.area * norm / (det * det);
        self.area += rest.area;
    }

    /// Mean symmetric Dirichlet energy over 4 after the best scale.
    pub fn mean(&self) -> f64 {
        sqrt(self.stretch * self.shrink) / (2.0 * self.area)
    }
}

/// Mean symmetric Dirichlet energy over 4, after the best global scale. Faces of no area to speak of do not count.
pub fn distortion(uv: &[DVec2], rest: &[Rest]) -> f64 {
    let strain = Strain::of(uv, rest);
    if strain.area > 0.0 { strain.mean() } else { 1.0 }
}
