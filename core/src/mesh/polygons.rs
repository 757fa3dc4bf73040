//! The user's polygons, as every stage that takes them sees them.

use super::view::NONE;
use core::ops::Range;
use glam::{DVec2, DVec3};

/// The user's polygons, nothing merged.
#[derive(Clone, Copy)]
pub struct Polygons<'a> {
    /// Vertex positions in the user's units.
    pub positions: &'a [DVec3], // (n)
    /// Vertex index of each polygon corner, polygon after polygon.
    pub corners: &'a [u32], // (c)
    /// First corner of each polygon, and the number of corners at the end.
    pub polygon_start: &'a [u32], // (p + 1)
    /// UVs that came with the corners, whose borders become forced cuts; NaN where a corner has none.
    pub kept_uv: Option<&'a [DVec2]>, // (c)
}

impl Polygons<'_> {
    /// The corners of each polygon.
    pub fn polygons(&self) -> impl Iterator<Item = Range<u32>> {
        self.polygon_start.windows(2).map(|ends| ends[0]..ends[1])
    }

    /// Triangles that the polygons would have if none were degenerate, and the most corners of one polygon.
    pub(super) fn size(&self) -> (usize, usize) {
        self.polygons().fold((0, 0), |(triangles, longest), corners| {
            let n = corners.len().min(self.corners.len());
            (usize::saturating_add(triangles, n.saturating_sub(2)), longest.max(n))
        })
    }

    /// What needs of memory depend on.
    pub fn counts(&self) -> Counts {
        let (triangles, longest) = self.size();
        let polygons = self.polygon_start.len().saturating_sub(1);
        Counts { vertices: self.positions.len(), corners: self.corners.len(), polygons, triangles, longest }
    }
}

/// How large a mesh is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Vertices.
    pub vertices: usize,
    /// Polygon corners.
    pub corners: usize,
    /// Polygons.
    pub polygons: usize,
    /// Triangles that the polygons would have if none were degenerate.
    pub triangles: usize,
    /// The most corners of one polygon.
    pub longest: usize,
}

impl Counts {
    /// Whether 32 bits cannot number all corners.
    pub(super) const fn are_too_many(&self) -> bool {
        let most = NONE as usize / 3;
        self.triangles >= most || self.corners >= most || self.vertices >= most
    }

    /// Those of a mesh of triangles.
    pub const fn of_triangles(vertices: usize, triangles: usize) -> Self {
        Self { vertices, corners: triangles.saturating_mul(3), polygons: triangles, triangles, longest: 3 }
    }
}
