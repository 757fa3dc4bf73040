//! The formats of meshes, by the endings of their files.

use std::path::Path;

/// A format of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are the formats'")]
pub enum Format {
    Obj,
    Ply,
    Stl,
    Off,
    Glb,
    Gltf,
    Fbx,
}

impl Format {
    /// By the ending of `path`.
    pub fn of(path: &Path) -> Option<Self> {
        Self::named(&path.extension()?.to_string_lossy())
    }

    /// By an ending without its point.
    pub fn named(ending: &str) -> Option<Self> {
        Some(match ending.to_lowercase().as_str() {
            "obj" => Format::Obj,
            "ply" => Format::Ply,
            "stl" => Format::Stl,
            "off" => Format::Off,
            "glb" => Format::Glb,
            "gltf" => Format::Gltf,
            "fbx" => Format::Fbx,
            _ => return None,
        })
    }

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self {
            Format::Obj => "OBJ",
            Format::Ply => "PLY",
            Format::Stl => "STL",
            Format::Off => "OFF",
            Format::Glb => "GLB",
            Format::Gltf => "glTF",
            Format::Fbx => "FBX",
        }
    }

    /// Whether a mesh that is drawn several times stands once in a file.
    pub fn has_instances(self) -> bool {
        matches!(self, Format::Glb | Format::Gltf | Format::Fbx)
    }

    /// Why no UVs are written in this format; `None` where they are.
    pub fn refusal(self) -> Option<&'static str> {
        match self {
            Format::Stl => Some("STL holds no UVs"),
            Format::Off => Some("OFF holds no UVs a corner"),
            Format::Fbx => Some("FBX is read but not written"),
            Format::Obj | Format::Ply | Format::Glb | Format::Gltf => None,
        }
    }
}
