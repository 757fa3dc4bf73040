//! An OBJ file in memory: its bytes, its mesh, and the places that a new atlas changes.

use crate::formats::model::Model;

/// An OBJ file: its bytes, its mesh, and what a new atlas changes.
pub struct ObjFile {
    /// The file's bytes.
    pub source: Vec<u8>,
    /// The polygons of its `f` statements, and what stands beside them.
    pub model: Model,
    /// Normal of each corner, from 1 as in the file; 0: none. Empty where no corner has one.
    pub corner_normal: Vec<u32>, // (c) or (0)
    /// What is rewritten, in the order of the file.
    pub edits: Vec<Edit>,
}

/// A span of the file that does not survive as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edit {
    /// First byte.
    pub start: usize,
    /// End.
    pub end: usize,
    /// What becomes of it.
    pub kind: EditKind,
}

/// What becomes of a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditKind {
    /// A `vt` line: dropped.
    Texture,
    /// The statement of the next polygon: its corners are rewritten.
    Face,
    /// A statement that is no polygon and refers to the old `vt` lines: the references are taken out.
    Detach,
}
