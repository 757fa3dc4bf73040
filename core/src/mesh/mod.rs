//! Meshes: views, adjacency, repair.

pub mod topology;
pub mod view;
