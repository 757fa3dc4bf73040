//! A triangle mesh in the caller's memory, and the corner arithmetic that the whole core uses.
//!
//! Corner `c = 3 f + i` is corner i of face f. The half-edge of corner c runs from its vertex to the vertex of
//! [`next`]`(c)`. Faces are counter-clockwise seen from outside.

use glam::DVec3;

/// No corner, face or vertex.
pub const NONE: u32 = u32::MAX;

/// Positions and triangles.
#[derive(Clone, Copy)]
pub struct MeshView<'a> {
    /// One point a vertex.
    pub positions: &'a [DVec3], // (n)
    /// Vertex indices of each triangle.
    pub faces: &'a [[u32; 3]], // (f)
}

impl MeshView<'_> {
    /// Vertex at corner `c`.
    #[inline]
    pub fn vertex(&self, c: u32) -> u32 {
        self.faces[(c / 3) as usize][(c % 3) as usize]
    }

    /// Position at corner `c`.
    #[inline]
    pub fn position(&self, c: u32) -> DVec3 {
        self.positions[self.vertex(c) as usize]
    }

    /// Number of corners.
    pub fn corner_count(&self) -> usize {
        self.faces.len() * 3
    }

    /// Twice the area of `face`, as a vector along its normal.
    pub fn area_vector(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.faces[face].map(|v| self.positions[v as usize]);
        (b - a).cross(c - a)
    }
}

/// The next corner of the same face, counter-clockwise.
#[inline]
pub const fn next(c: u32) -> u32 {
    if c % 3 == 2 { c - 2 } else { c + 1 }
}

/// The previous corner of the same face.
#[inline]
pub const fn prev(c: u32) -> u32 {
    match c % 3 {
        0 => c + 2,
        _ => c - 1,
    }
}
