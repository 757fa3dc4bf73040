//! Meshes: views, adjacency, repair.

pub mod normals;
pub mod topology;
pub mod view;
