//! The JSON of a run that ended without an atlas.

use crate::base::failure::Failure;
use serde::Serialize;
use std::path::Path;

/// Why there is no atlas.
#[derive(Debug, Serialize)]
pub struct FailureReport {
    /// Version of seamwright.
    pub version: &'static str,
    /// What should have been read.
    pub input: FailedInput,
    /// The exit code.
    pub code: u8,
    /// What the user reads.
    pub error: String,
}

/// The input of a run that failed.
#[derive(Debug, Serialize)]
pub struct FailedInput {
    /// Path as given.
    pub file: String,
}

impl FailureReport {
    /// What to tell of `failure`, where `input` was to be unwrapped.
    pub fn new(input: &Path, failure: &Failure) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            input: FailedInput { file: input.display().to_string() },
            code: failure.code(),
            error: failure.to_string(),
        }
    }
}
