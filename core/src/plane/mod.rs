//! Geometry of the plane: the integer grid of UVs, exact overlaps on it, hulls, rigid motions, segments.

pub mod crowding;
pub mod grid;
pub mod hull;
pub mod motion;
pub mod overlap;
pub mod segment;
