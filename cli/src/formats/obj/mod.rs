//! Wavefront OBJ, read and written so that the user's file stays the user's.
//!
//! - [`mod@file`]: the file's bytes, its mesh, and the places that a new atlas changes
//! - [`statement`], `field`: lines, continuations and words of a file's bytes
//! - [`read`], [`problem`], `smoothing`, `pieces`: bytes to file
//! - [`mod@write`]: the same bytes with new `vt` lines and face corners
//! - [`compose`], [`material`]: an OBJ from scratch, and its materials, for meshes that came in another format

pub mod compose;
mod field;
pub mod file;
pub mod material;
mod pieces;
pub mod problem;
pub mod read;
mod smoothing;
pub mod statement;
pub mod write;
