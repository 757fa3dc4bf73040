//! The command's parts, as modules that its tests and benches reach.
#![warn(missing_docs)]

pub mod hierarchy;
pub mod picture;
