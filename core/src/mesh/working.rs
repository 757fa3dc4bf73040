//! The working mesh that repair makes of the user's polygons: manifold, oriented, in a box of its own size.

use super::view::MeshView;
use glam::DVec3;

/// Mark in [`Working::fixed`]: a diagonal inside a polygon, never to be cut.
pub const DIAGONAL: u8 = 1;
/// Mark in [`Working::fixed`]: a border of the UVs that the input came with, to be cut whatever it costs.
pub const FORCED: u8 = 2;
/// Mark in [`Working::fixed`]: an edge where a crack was closed, see [`cracks`](super::cracks).
pub const CLOSED: u8 = 4;

/// The working mesh.
#[derive(Clone, Copy, Debug)]
pub struct Working<'a> {
    /// Working vertices of each triangle.
    pub faces: &'a [[u32; 3]], // (f)
    /// Positions, box centred on the origin, its largest side 1.
    pub positions: &'a [DVec3], // (v)
    /// Input corner that each working corner stands for.
    pub corner_source: &'a [u32], // (3 f)
    /// Lowest input vertex of those that each working vertex stands for: at one place, or welded over a crack.
    pub vertex_source: &'a [u32], // (v)
    /// The half-edge on the other side of each half-edge, or `NONE` on the border.
    pub twin: &'a [u32], // (3 f)
    /// 0, [`DIAGONAL`], [`FORCED`] or [`CLOSED`] for each half-edge, the same for twins.
    pub fixed: &'a [u8], // (3 f)
    /// Input polygon of each face; the faces of one polygon stand together.
    pub polygon: &'a [u32], // (f)
    /// Component of each face, numbered by lowest face.
    pub component: &'a [u32], // (f)
    /// How many components there are.
    pub component_count: usize,
    /// The same for each input vertex; `NONE` for vertices that no corner names.
    pub welded: &'a [u32], // (n)
    /// Input position = working position x extent + centre.
    pub centre: DVec3,
    /// Largest side of the input's box, of vertices that a face has. Infinite only if that is beyond f64.
    pub extent: f64,
}

impl<'a> Working<'a> {
    /// Positions and faces.
    pub fn mesh(&self) -> MeshView<'a> {
        MeshView { positions: self.positions, faces: self.faces }
    }
}
