//! Meshes: views, adjacency, repair.

pub mod polygon;
pub mod topology;
pub mod view;
