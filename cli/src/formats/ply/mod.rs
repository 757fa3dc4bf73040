//! PLY, text and binary.

pub mod read;
