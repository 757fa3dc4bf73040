//! PLY, text and binary.
//!
//! - `header`, `body`: what a file says of its values, and the values
//! - [`read`]: values to mesh

mod body;
mod header;
pub mod read;
