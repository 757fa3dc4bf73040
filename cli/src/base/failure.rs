//! Why the command ends early: what the user reads, and the exit code that a script reads.
//!
//! | code | meaning |
//! |---|---|
//! | 0 | done |
//! | 2 | the command line is wrong (clap's own errors too) |
//! | 3 | an input cannot be read, or is no mesh |
//! | 4 | an output cannot be written |
//! | 5 | the run could not reach what was asked |
//! | 130 | stopped by Ctrl-C or a termination signal, as shells report it |
//!
//! After every code but 0 all outputs are as they were before, with two exceptions: code 5 for a missed bound, or for faces
//! that overlap, comes after the atlas was written; and a report that was asked for says why there is no atlas (3 and 5).

use core::fmt;
use std::io;
use std::path::Path;

/// Why the command ends early. The text names file, line or flag, what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The flags contradict each other.
    Usage(String),
    /// An input cannot be read, or is no mesh.
    Input(String),
    /// An output cannot be written.
    Output(String),
    /// The run could not reach what was asked.
    Unreached(String),
    /// Ctrl-C or a termination signal.
    Stopped,
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Usage(_) => 2,
            Failure::Input(_) => 3,
            Failure::Output(_) => 4,
            Failure::Unreached(_) => 5,
            Failure::Stopped => 130,
        }
    }

    /// `path` could not be written.
    pub fn output(flag: &str, path: &Path, error: &io::Error) -> Self {
        let remedy = match error.kind() {
            io::ErrorKind::NotFound => "create its folder first",
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "choose a place where you may write, or change its permissions"
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "make room or choose another place",
            io::ErrorKind::IsADirectory => "name a file, not a folder",
            _ => "choose another place",
        };
        Failure::Output(format!("{flag} {}: cannot be written: {error}; {remedy}", path.display()))
    }

    /// `path` could not be read.
    pub fn input(path: &Path, error: &io::Error) -> Self {
        let remedy = match error.kind() {
            io::ErrorKind::NotFound => "check the path",
            io::ErrorKind::PermissionDenied => "change its permissions",
            io::ErrorKind::IsADirectory => "name a file, not a folder",
            _ => "check the file and its disk",
        };
        Failure::Input(format!("{}: cannot be read: {error}; {remedy}", path.display()))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Usage(text) | Failure::Input(text) | Failure::Output(text) | Failure::Unreached(text) => {
                f.write_str(text)
            }
            Failure::Stopped => f.write_str("stopped; no output was written"),
        }
    }
}

impl std::error::Error for Failure {}
