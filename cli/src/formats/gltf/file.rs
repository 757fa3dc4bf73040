//! A glTF file in memory: its JSON and bytes as they were, its mesh, and which corner of the mesh is which index of the file.

use super::buffers::Buffers;
use super::container::Container;
use super::document::Document;
use super::numbers::Numbers;
use crate::formats::model::Model;
use std::path::PathBuf;

/// A glTF file: its parts, its mesh, and what a new atlas changes.
pub struct GltfFile {
    /// The JSON, and the container's chunks but the binary one, which is the first buffer.
    pub(super) container: Container,
    /// The part of the JSON that a mesh needs.
    pub(super) document: Document,
    pub(super) buffers: Buffers,
    /// The surfaces that the mesh is made of.
    pub(super) surfaces: Vec<Surface>,
    /// Where its files lie.
    pub(super) folder: PathBuf,
    /// Its triangles and what stands beside them.
    pub model: Model,
}

/// The triangles of one primitive, or of several that have the same vertices and indices.
pub(super) struct Surface {
    /// Mesh and primitive of each that has these triangles.
    pub users: Vec<[usize; 2]>,
    /// Vertices of the file's triangles.
    pub triangles: Vec<[u32; 3]>,
    /// First corner of the mesh.
    pub first: usize,
    /// Whether the node that the mesh was placed by mirrors it, so that its triangles are turned round there.
    pub is_mirrored: bool,
}

impl GltfFile {
    pub(super) fn numbers(&self) -> Numbers<'_> {
        Numbers { document: &self.document, buffers: &self.buffers }
    }
}

impl Surface {
    /// The mesh's corner for corner `k` of the file's triangle `t`.
    pub fn corner(&self, t: usize, k: usize) -> usize {
        let turned = if self.is_mirrored { [0, 2, 1] } else { [0, 1, 2] };
        self.first + 3 * t + turned[k]
    }
}
