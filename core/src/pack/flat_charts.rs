//! Flattened charts as packing takes them.

use glam::DVec2;

/// Triangles of flattened charts, in natural scale: one length unit is the same number of texels in each.
#[derive(Clone, Copy)]
pub struct FlatCharts<'a> {
    /// UV vertices.
    pub uv: &'a [DVec2], // (n)
    /// UV vertices of each triangle.
    pub faces: &'a [[u32; 3]], // (f)
    /// Chart of each triangle; triangles of charts at or above `count` are left out.
    pub chart: &'a [u32], // (f)
    /// Number of charts.
    pub count: usize,
    /// 1 where a chart stands upright as it is and is turned by quarters only; charts beyond the list turn freely.
    pub upright: &'a [u8],
}
