//! Labels of faces from files and to files: which part each polygon of a mesh belongs to.

mod glb;
mod places;
pub mod read;
mod text;
pub mod write;
