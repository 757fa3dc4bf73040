//! Exposure as it was sampled for figures.

use seamwright_core::rays::directions::Spread;
use serde::Serialize;

/// How directions were weighed for exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weighting {
    /// Every direction of the hemisphere alike.
    Uniform,
    /// By the cosine with the normal.
    Cosine,
}

impl Weighting {
    pub(super) fn spread(self) -> Spread {
        match self {
            Weighting::Uniform => Spread::Uniform,
            Weighting::Cosine => Spread::Cosine,
        }
    }
}

/// Exposure of each vertex: 1 open, 0 occluded.
#[derive(Clone, Copy)]
pub struct SampledExposure<'a> {
    /// One value a vertex.
    pub values: &'a [f32], // (n)
    /// How it was sampled.
    pub weighting: Weighting,
}
