//! How maps are trained, and trained maps in files.

pub mod map_file;
pub mod trainer;
