//! The seamwright command as a library: files in and out, threads, progress, reports.
#![forbid(unsafe_code)]

pub mod measure;
