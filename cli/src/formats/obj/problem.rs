//! What can be wrong with an OBJ file, in words that say what to do.
//!
//! Only what leaves no mesh is an error; what a reader can get past is a warning (see [`super::read`]).

use core::fmt;

/// Why a file is no mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjError {
    /// Line from 1; 0 where the whole file is meant.
    pub line: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What is wrong with a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A `v` with fewer than three coordinates.
    FewCoordinates {
        /// Coordinates that are there.
        given: usize,
    },
    /// A coordinate that is no decimal number.
    NotANumber {
        /// The word.
        word: String,
    },
    /// A coordinate that is NaN, infinite, or too large for a double.
    NotFinite {
        /// The word.
        word: String,
    },
    /// A face corner that is not `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    NotACorner {
        /// The word.
        word: String,
    },
    /// A corner with vertex index 0.
    ZeroIndex,
    /// A corner that names a vertex that is not there.
    OutOfRange {
        /// The index as written.
        index: i64,
        /// Vertices that it could name.
        count: usize,
    },
    /// The file begins like UTF-16 text.
    Utf16,
    /// More vertices or corners than 32-bit indices can name.
    TooLarge,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Problem::FewCoordinates { given } => {
                write!(f, "this vertex has {given} of its 3 coordinates; complete the line")
            }
            Problem::NotANumber { word } => write!(f, "'{word}' is not a decimal number; correct the coordinate"),
            Problem::NotFinite { word } => {
                write!(
                    f,
                    "the coordinate '{word}' is not finite; correct it or remove the vertex's faces and the vertex"
                )
            }
            Problem::NotACorner { word } => {
                write!(f, "'{word}' is not a face corner; write v, v/vt, v//vn or v/vt/vn with whole numbers")
            }
            Problem::ZeroIndex => {
                write!(f, "vertex index 0, but OBJ counts from 1; correct the index or remove the face")
            }
            Problem::OutOfRange { index, count } if *index > 0 => {
                write!(
                    f,
                    "vertex index {index}, but the file has {count} vertices; correct the index or remove the face"
                )
            }
            Problem::OutOfRange { index, count } => {
                write!(
                    f,
                    "vertex index {index}, but only {count} vertices stand above this line; correct the index or remove the \
                     face"
                )
            }
            Problem::Utf16 => write!(f, "the file is UTF-16 text; save it as UTF-8 or ASCII"),
            Problem::TooLarge => write!(f, "more than 4,294,967,294 vertices or corners; split the mesh"),
        }
    }
}

impl fmt::Display for ObjError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => self.problem.fmt(f),
            line => write!(f, "line {line}: {}", self.problem),
        }
    }
}

impl std::error::Error for ObjError {}
