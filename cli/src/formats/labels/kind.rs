//! The kinds of files that hold labels.

use std::path::Path;

/// What kind of file of labels an ending stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelKind {
    /// One integer a face.
    Seg,
    /// A list, or a map from face to label.
    Json,
    /// A mesh with labels or colours.
    Ply,
    /// A mesh with colours.
    Glb,
}

impl LabelKind {
    /// By the ending of `path`.
    pub fn of(path: &Path) -> Option<Self> {
        Some(match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "seg" => LabelKind::Seg,
            "json" => LabelKind::Json,
            "ply" => LabelKind::Ply,
            "glb" => LabelKind::Glb,
            _ => return None,
        })
    }
}
