//! What is wanted of a file.

/// What is wanted of a file. The default is what a file is written back from: the first set of UVs, every mesh once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Which of its sets of UVs.
    pub uv_set: u32,
    /// Whether a mesh that a scene draws several times is read as often as it is drawn, and none that it does not draw.
    pub copies: bool,
}
