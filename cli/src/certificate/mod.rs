//! Whether an atlas keeps its rules, decided from the written files alone.
//!
//! Nothing here is shared with what makes atlases: neither predicates nor the way from polygons to triangles.
//!
//! - `planar`, [`distance`]: exact answers about points in the plane
//! - `boxes`: what may touch what, without looking at all pairs
//! - `rings`, `tiles`: polygons without what has no place in the plane, and the triangles that they are in UV
//! - `facing`: faces that their neighbours outvote
//! - `charts`, `gutters`: what hangs together, and how far apart it is kept
//! - `stacks`: charts that lie on others as a whole
//! - `same`: whether a mesh is another with other UVs
//! - [`fault`], [`verdict`]: what can be wrong, and the whole

mod boxes;
mod charts;
pub mod distance;
mod facing;
pub mod fault;
mod gutters;
mod planar;
mod rings;
mod same;
mod stacks;
mod tiles;
pub mod verdict;
