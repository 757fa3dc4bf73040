//! Meshes: views, adjacency, repair.

pub mod collapse;
pub mod decimate;
pub mod grid;
pub mod overlap;
pub mod quadric;
pub mod ring;
pub mod topology;
pub mod view;
