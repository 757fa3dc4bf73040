//! The JSON report of a run.
//!
//! - [`document`]: the whole
//! - [`transfer`]: the whole of a run that carried an atlas over
//! - [`asked`], [`result`], [`learning`], [`parts`]: its chapters

pub mod asked;
pub mod document;
pub mod failed;
pub mod learning;
pub mod parts;
pub mod result;
pub mod transfer;
