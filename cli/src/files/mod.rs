//! Outputs on disk.

pub mod drafts;
