//! The JSON report of a run.
//!
//! - [`document`]: the whole
//! - [`asked`], [`result`], [`learning`], [`parts`]: its chapters

pub mod asked;
pub mod document;
pub mod failed;
pub mod learning;
pub mod parts;
pub mod result;
