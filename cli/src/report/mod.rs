//! The JSON report of a run.

pub mod document;
