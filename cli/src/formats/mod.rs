//! Files to meshes and back: a folder for each format.
//!
//! - [`loaded`]: a mesh from a file by its ending, and back to a file
//! - [`obj`], [`ply`], [`stl`], [`off`], [`fbx`], [`gltf`]: the formats of meshes
//! - [`labels`]: files that tell the parts of a mesh apart
//! - [`mod@format`], [`reading`], [`target`]: which is which, what is wanted of a file, and where it goes
//! - [`model`], [`mark`], [`groups`], [`error`]: what they have in common

pub mod error;
pub mod fbx;
pub mod format;
pub mod gltf;
pub mod groups;
pub mod labels;
pub mod loaded;
pub mod mark;
pub mod model;
pub mod obj;
pub mod off;
pub mod ply;
pub mod reading;
pub mod stl;
pub mod target;
