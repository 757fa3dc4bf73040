//! Meshes in memory, whatever file they came from.
//!
//! - [`polygons`]: a mesh as its file has it
//! - [`view`]: the same, held by somebody else
//! - [`triangles`]: its triangles
//! - [`precision`]: how exact its file's coordinates are

pub mod polygons;
pub mod precision;
pub mod triangles;
pub mod view;
