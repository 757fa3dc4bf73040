//! Why a file is no mesh, with the line where there is one.

use core::fmt;

/// Why a file is no mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Line from 1; 0 where the whole file is meant.
    pub line: usize,
    /// What is wrong, and what to do.
    pub problem: String,
}

impl FormatError {
    /// About no line in particular.
    pub fn whole(problem: impl Into<String>) -> Self {
        Self { line: 0, problem: problem.into() }
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => f.write_str(&self.problem),
            line => write!(f, "line {line}: {}", self.problem),
        }
    }
}

impl std::error::Error for FormatError {}
