//! Charts: a surface with cuts, what the cuts leave, pieces that are alike, paths over it, and work on charts side by side.

pub mod bands;
pub mod congruence;
pub mod copies;
#[cfg(test)]
mod copies_tests;
pub mod cut_mesh;
pub mod halves;
pub mod inland;
pub mod list;
pub mod mirror;
pub mod patch;
pub mod paths;
pub mod pieces;
pub mod quads;
pub mod seams;
pub mod strip;
pub mod surface;
#[cfg(test)]
pub mod surface_tests;
pub mod wedge_paths;
pub mod work;
