//! Files to meshes and back: a folder for each format.

pub mod bare;
pub mod gltf;
pub mod labels;
pub mod loaded;
pub mod obj;
pub mod ply;
pub mod stl;
