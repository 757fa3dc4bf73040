//! A polygon mesh in memory, whatever file it came from.

use glam::{DVec2, DVec3, Vec3};

/// A polygon mesh as its file has it: nothing merged, nothing repaired.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, finite.
    pub positions: Vec<DVec3>, // (n)
    /// Vertex of each corner, polygon after polygon; each below n.
    pub corners: Vec<u32>, // (c)
    /// First corner of each polygon, and the number of corners at the end; three corners a polygon at least.
    pub polygon_start: Vec<u32>, // (p + 1)
    /// UV of each corner, where the file has any; NaN where a corner has none.
    pub corner_uv: Option<Vec<DVec2>>, // (c)
    /// Normal of each corner, of any length, where the file has any; zero where a corner has none.
    pub corner_normals: Option<Vec<Vec3>>, // (c)
    /// What the file says of the edge from each corner to the next of its polygon: marks of
    /// [`EdgeData`](seamwright_core::price::given::EdgeData).
    pub edge_marks: Option<Vec<u8>>, // (c)
    /// How far positions may be from what they stand for; see [`precision`](super::precision).
    pub tolerance: f64,
}

/// No UV.
pub const NO_UV: DVec2 = DVec2::NAN;

impl Mesh {
    /// A mesh of nothing.
    pub fn new() -> Self {
        Self { polygon_start: vec![0], ..Self::default() }
    }

    /// The coordinate farthest from 0.
    pub fn largest_coordinate(&self) -> f64 {
        self.positions.iter().fold(0.0, |largest, p| f64::max(largest, p.abs().max_element()))
    }

    /// Number of polygons.
    pub fn polygon_count(&self) -> usize {
        self.polygon_start.len().saturating_sub(1)
    }

    /// Corners of polygon `p`, as a range of the corner arrays.
    pub fn polygon(&self, p: usize) -> core::ops::Range<usize> {
        self.polygon_start[p] as usize..self.polygon_start[p + 1] as usize
    }

    /// Each polygon's corners, as ranges of the corner arrays.
    pub fn polygons(&self) -> impl Iterator<Item = core::ops::Range<usize>> + '_ {
        (0..self.polygon_count()).map(|p| self.polygon(p))
    }
}
