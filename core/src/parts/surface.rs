//! What is cut into parts: a surface with what rays have found inside of it.

use crate::mesh::view::MeshView;
use glam::Vec3;

/// What is cut into parts.
#[derive(Clone, Copy)]
pub struct PartSurface<'a> {
    /// Oriented manifold triangles, as from `repair`.
    pub mesh: MeshView<'a>,
    /// Their twins.
    pub twin: &'a [u32], // (3 f)
    /// Shape diameter of each face, in the mesh's units.
    pub diameter: &'a [f32], // (f)
    /// Whether the straight way from the first to the second point meets no face.
    pub sees: &'a (dyn Fn(Vec3, Vec3) -> bool + Sync),
}
