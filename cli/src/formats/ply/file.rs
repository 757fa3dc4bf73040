//! A PLY file in memory: its bytes, its mesh, and the places that a new atlas changes.

use super::header::PlyHeader;
use crate::formats::model::Model;

/// A PLY file: its bytes, its mesh, and what a new atlas changes.
pub struct PlyFile {
    /// The file's bytes.
    pub source: Vec<u8>,
    pub(super) header: PlyHeader,
    /// The element that has polygons, if one has.
    pub(super) faces: Option<usize>,
    /// Where each of its items ends, and whether it is a polygon of the mesh; strips, of which none is, end together.
    pub(super) face_ends: Vec<(usize, bool)>,
    /// Where the first strip begins, where there are strips.
    pub(super) strips_start: usize,
    /// Where each value of a property of UVs stands: element, property, first byte and end, in the order of the file.
    pub(super) uv_values: Vec<(usize, usize, usize, usize)>,
    /// What stands in lines behind the values that the header names, first byte and end.
    pub(super) beyond: Vec<(usize, usize)>,
    /// Its polygons and what stands beside them.
    pub model: Model,
}
