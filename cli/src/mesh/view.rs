//! Polygons over positions that somebody else holds.

use glam::{DVec2, DVec3};

/// Polygons over positions, as a file has them.
#[derive(Clone, Copy)]
pub struct PolygonView<'a> {
    /// Vertex positions.
    pub positions: &'a [DVec3], // (n)
    /// Vertex of each polygon corner.
    pub corners: &'a [u32], // (c)
    /// First corner of each polygon, and the number of corners at the end.
    pub polygon_start: &'a [u32], // (p + 1)
    /// UV of each corner, NaN where it has none; `None` where the file has none at all.
    pub corner_uv: Option<&'a [DVec2]>, // (c)
}
