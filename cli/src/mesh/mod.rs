//! Meshes in memory, whatever file they came from.

pub mod polygons;
