//! Meshes: views, adjacency, and the repair that turns any polygons into manifolds.

pub mod collapse;
pub mod cracks;
pub mod decimate;
pub mod frame;
pub mod loops;
pub mod normals;
pub mod polygon;
pub mod polygons;
pub mod quadric;
pub mod repair;
pub mod ring;
pub mod topology;
pub mod triangles;
pub mod view;
pub mod working;

mod draft;
mod facets;
mod idle;
mod joints;
mod manifold;
mod open_side; // the steps of `repair`
mod orient;
mod partners;
#[cfg(test)]
mod repair_tests;
mod unit_box;
pub mod weld;
