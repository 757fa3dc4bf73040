//! From polygons to a UV atlas: the one place that joins the stages.

use crate::base::{progress::Progress, scratch::Scratch, scratch::ScratchTooSmall, workers::Workers};
use crate::rays::bvh::BuildBvh;
use glam::{DVec2, DVec3};

/// The user's mesh: polygons over positions, nothing merged.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// Vertex positions in the user's units; finite.
    pub positions: &'a [DVec3], // (n)
    /// Vertex index of each polygon corner, polygon after polygon.
    pub corners: &'a [u32], // (c)
    /// First corner of each polygon, and the number of corners at the end.
    pub polygon_start: &'a [u32], // (p + 1)
    /// UVs that the file came with, one a corner, whose borders stay cuts (`--keep-seams`). NaN: no UV.
    pub kept_uv: Option<&'a [DVec2]>, // (c)
}

/// How many charts a connected component may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Charts {
    /// As many as hide the seams best.
    #[default]
    Few,
    /// One, where overlap-free flattening and the bound allow it.
    One,
}

/// How charts are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Packing {
    /// Equal texel density, rotations, shapes in one another's gaps.
    #[default]
    Tight,
    /// One cell of a square grid a chart, each normalised to its cell (DESIGN 4.10).
    Grid,
}

/// What the user can ask for.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Bound on the mean symmetric Dirichlet energy over 4 (1 is an isometry); above 1.
    pub distortion: f64,
    /// Charts a component.
    pub charts: Charts,
    /// Placement.
    pub packing: Packing,
    /// Texture side in texels, for the padding.
    pub size: u32,
    /// Empty texels between charts.
    pub padding: u32,
    /// Exposure rays a vertex.
    pub rays: u32,
    /// Seed of every random value.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            distortion: 1.025,
            charts: Charts::Few,
            packing: Packing::Tight,
            size: 1024,
            padding: 2,
            rays: 512,
            seed: 0,
        }
    }
}

/// Where the atlas is written.
pub struct Output<'a> {
    /// UV of each input corner, in [0, 1]^2, on a grid of 2^-24.
    pub corner_uv: &'a mut [DVec2], // (c)
    /// Chart of each input polygon, 0..chart_count; parts of nothing are `NONE`.
    pub polygon_chart: &'a mut [u32], // (p)
    /// Exposure of each input vertex in [0, 1]; 1 is open.
    pub exposure: &'a mut [f32], // (n)
}

/// What was done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Charts in the atlas.
    pub chart_count: usize,
    /// Mean symmetric Dirichlet energy over 4, after the best global scale.
    pub distortion: f64,
    /// Share of the unit square that charts cover.
    pub utilisation: f64,
}

/// Why there is no atlas. Outputs are unspecified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnwrapError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// The progress callback asked to stop.
    Cancelled,
    /// No polygon has three different corners.
    NoTriangle,
    /// A coordinate of this vertex is NaN or infinite.
    NotFinite {
        /// Input vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there.
    BadIndex {
        /// Input corner.
        corner: usize,
    },
}

impl From<ScratchTooSmall> for UnwrapError {
    fn from(e: ScratchTooSmall) -> Self {
        UnwrapError::Scratch(e)
    }
}

impl core::fmt::Display for UnwrapError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            UnwrapError::Scratch(e) => e.fmt(f),
            UnwrapError::Cancelled => write!(f, "stopped on request"),
            UnwrapError::NoTriangle => write!(f, "the mesh holds no triangle with three different corners"),
            UnwrapError::NotFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not a number"),
            UnwrapError::BadIndex { corner } => write!(f, "corner {corner} names a vertex that does not exist"),
        }
    }
}

impl core::error::Error for UnwrapError {}

/// Scratch bytes that [`unwrap`] asks for.
pub fn unwrap_need(input: &Input, settings: &Settings) -> usize {
    let _ = settings;
    input.corners.len() * 512
}

/// Makes the atlas with the exact method (no training).
pub fn unwrap(
    output: Output,
    input: &Input,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Report, UnwrapError> {
    scratch.require(unwrap_need(input, settings))?;
    let _ = (output, bvh, workers, progress);
    Err(UnwrapError::NoTriangle)
}
