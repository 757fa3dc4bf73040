//! How maps are trained, and trained maps in files.
//!
//! - [`trainer`]: settings, maps and losses
//! - [`settings`]: from a preset, a file and flags
//! - [`map_file`]: trained maps kept

pub mod map_file;
pub mod settings;
pub mod trainer;
