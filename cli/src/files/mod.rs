//! Outputs on disk.
//!
//! - [`drafts`]: they appear whole or not at all
//! - [`paths`]: which file a path names

pub mod drafts;
pub mod paths;
