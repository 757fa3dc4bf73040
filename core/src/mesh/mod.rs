//! Meshes: views, adjacency, repair.

pub mod grid;
pub mod overlap;
pub mod topology;
pub mod view;
