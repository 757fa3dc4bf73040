//! What the fuzz targets share: meshes and settings out of bytes, and what must hold of every atlas.
//!
//! The bytes are read from the front, a byte a choice where that can be, so that changing one changes one thing; where they
//! end, zeros follow. Runs take milliseconds: meshes of some dozen triangles, few rays, little search.

pub mod bytes;
pub mod case;
pub mod check;
pub mod round_trip;
pub mod seeds;

/// Endings of meshes that the targets `files` and `round_trip` write and read, by their first byte.
pub const MESHES: [&str; 7] = ["obj", "ply", "stl", "glb", "gltf", "off", "fbx"];

/// Endings of what `files` reads beside them, by the numbers behind: labels, a map, settings.
pub const OTHERS: [&str; 6] = ["seg", "json", "ply", "glb", "map", "toml"];
