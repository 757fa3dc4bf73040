//! PLY, text and binary, read and written so that the user's file stays the user's.
//!
//! - [`mod@file`]: the file's bytes, its mesh, and the places that a new atlas changes
//! - `header`, `body`, `names`: what a file says of its values, the values, and what UVs are called
//! - [`read`]: bytes to file
//! - [`mod@write`]: the same bytes with other UVs
//! - [`compose`]: a PLY from scratch, for meshes that came in another format

mod body;
pub mod compose;
pub mod file;
mod header;
mod names;
pub mod read;
pub mod write;
