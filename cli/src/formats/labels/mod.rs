//! Labels of faces from files and to files: which part each polygon of a mesh belongs to.
//!
//! - [`of_faces`], [`kind`]: labels in memory, and the files that hold them
//! - `text`: `.seg` and `.json`, which go by the order of faces
//! - `places`: coloured `.ply` and `.glb`, whose faces are found by where their vertices are
//! - [`read`] joins them; [`mod@write`], `glb`: the same four, written

mod glb;
pub mod kind;
pub mod of_faces;
mod places;
pub mod read;
mod text;
pub mod write;
