//! The two sides of a transfer, as its stages read them.

use super::sheets::NearestFace;
use super::source::SourceAtlas;
use crate::charts::surface::Surface;
use crate::mesh::working::Working;

/// What an atlas is laid on, and from what.
pub struct MeshAndAtlas<'w> {
    /// The mesh.
    pub onto: &'w Working<'w>,
    /// The source.
    pub atlas: &'w SourceAtlas<'w>,
    /// The mesh, in the frame of the source.
    pub surface: &'w Surface<'w>,
    /// The closest place of the source to each face.
    pub hits: &'w [NearestFace], // (f)
    /// Side of the texture in texels.
    pub size: u32,
}
