//! What the pipeline takes and where it writes: the user's polygons, and slices for UVs, charts and exposure.

use super::report::UnwrapError;
use crate::mesh::polygons::Polygons;
use crate::price::given::EdgeData;
use glam::{DVec2, DVec3};

/// The user's mesh: polygons over positions, nothing merged. [`Input::new`] fills what a caller has nothing to say about.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// Vertex positions in the user's units; finite.
    pub positions: &'a [DVec3], // (n)
    /// Vertex index of each polygon corner, polygon after polygon.
    pub corners: &'a [u32], // (c)
    /// First corner of each polygon, and the number of corners at the end.
    pub polygon_start: &'a [u32], // (p + 1)
    /// UVs that the file came with, one a corner, whose borders stay cuts (`--keep-seams`). NaN, or beyond the list: no UV.
    pub kept_uv: Option<&'a [DVec2]>, // (c)
    /// Part of each polygon, whose borders become cuts: no chart has faces of two parts, and a piece of a part is one
    /// chart where that can be. Charts are numbered by part, see [`crate::finish::order::order_charts`]. Polygons beyond the list are one
    /// part of their own.
    pub parts: Option<&'a [u32]>, // (p)
    /// What the file or the caller says of edges: normals, weights, cuts.
    pub edges: EdgeData<'a>,
    /// How far positions may be from what they stand for, in the user's units: half the last digit of a file. 0: exact, or
    /// unknown.
    pub tolerance: f64,
}

impl<'a> Input<'a> {
    /// Polygons with nothing said about them.
    pub fn new(positions: &'a [DVec3], corners: &'a [u32], polygon_start: &'a [u32]) -> Self {
        let edges = EdgeData::default();
        Self { positions, corners, polygon_start, kept_uv: None, parts: None, edges, tolerance: 0.0 }
    }

    pub(super) fn polygons(&self) -> Polygons<'a> {
        let Input { positions, corners, polygon_start, kept_uv, .. } = *self;
        Polygons { positions, corners, polygon_start, kept_uv }
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

impl Output<'_> {
    /// The same once more.
    pub(super) fn again(&mut self) -> Output<'_> {
        let Self { corner_uv, polygon_chart, exposure } = self;
        Output { corner_uv, polygon_chart, exposure }
    }

    /// Whether every slice has one entry for each that is written to it.
    pub(super) fn fits(&self, input: &Input) -> Result<(), UnwrapError> {
        fits(input.corners.len(), self.corner_uv.len())?;
        fits(input.polygon_start.len().saturating_sub(1), self.polygon_chart.len())?;
        fits(input.positions.len(), self.exposure.len())
    }
}

/// Whether an output has the length that is expected.
pub(super) fn fits(expected: usize, given: usize) -> Result<(), UnwrapError> {
    if expected == given { Ok(()) } else { Err(UnwrapError::BadLength { expected, given }) }
}
