//! Files to meshes and back: a folder for each format.
//!
//! - [`loaded`]: a mesh from a file by its ending, and back to an OBJ
//! - [`obj`], [`ply`], [`stl`], [`gltf`]: the formats of meshes
//! - [`labels`]: files that tell the parts of a mesh apart
//! - [`model`], [`mark`], [`groups`], [`error`]: what they have in common

pub mod error;
pub mod gltf;
pub mod groups;
pub mod labels;
pub mod loaded;
pub mod mark;
pub mod model;
pub mod obj;
pub mod ply;
pub mod stl;
