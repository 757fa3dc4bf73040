//! What the fuzz targets share: meshes and settings out of bytes, and what must hold of every atlas.
//!
//! The bytes are read from the front, a byte a choice where that can be, so that changing one changes one thing; where they
//! end, zeros follow. Runs take milliseconds: meshes of some dozen triangles, few rays, little search.

pub mod bytes;
pub mod case;
pub mod check;
pub mod round_trip;
pub mod seeds;

/// Endings of the files that the target `files` writes and reads, by its first byte.
pub const ENDINGS: [&str; 7] = ["obj", "ply", "stl", "glb", "gltf", "seg", "json"];
