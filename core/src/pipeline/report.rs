//! What a run has done, and why there may be no atlas.

use super::settings::CountedWork;
use crate::base::pace::StageError;
use crate::base::progress::Stopped;
use crate::base::scratch::ScratchTooSmall;
use crate::finish::place::PlaceError;
use crate::mesh::repair::{RepairError, RepairSummary};

/// What was done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Charts in the atlas.
    pub chart_count: usize,
    /// Mean symmetric Dirichlet energy over 4, after the best global scale.
    pub distortion: f64,
    /// Share of the unit square that charts cover.
    pub utilisation: f64,
    /// Texels that charts keep from each other: as many as were asked for, unless so many charts have no room for that.
    pub padding: f64,
    /// Faces that are not counter-clockwise on the grid; 0 unless they have no area to speak of.
    pub flipped: usize,
    /// Faces that overlap another on the grid: 0, or there is no atlas but one of [`super::unwrap::Method::Neural`].
    pub overlapping: usize,
    /// Charts that lie on others on purpose, of all charts.
    pub stacked: usize,
    /// Edges that are cut though a weight forbids them: without, a piece could not be laid flat.
    pub forbidden_cuts: usize,
    /// Closed cracks that are cut all the same, since the shading breaks there.
    pub closed_breaks: usize,
    /// What was repaired.
    pub repaired: RepairSummary,
    /// Work that was done where a stage ended early: given as [`Settings::work`](super::settings::Settings::work) it gives this atlas again.
    pub ended_early: Option<CountedWork>,
}

/// Why there is no atlas. Outputs are unspecified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnwrapError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// The progress callback asked to stop.
    Cancelled,
    /// No polygon has three different corners.
    NoTriangle,
    /// A coordinate of this vertex is NaN or infinite.
    NotFinite {
        /// Input vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there.
    BadIndex {
        /// Input corner.
        corner: usize,
    },
    /// An output, or a list of learned maps, has not one entry for each that is written to it.
    BadLength {
        /// Entries that would fit.
        expected: usize,
        /// Entries that were there.
        given: usize,
    },
    /// The hierarchy that the caller built does not hold every face once.
    BadTree,
    /// Splitting and packing again and again left faces that overlap: there is no valid atlas to hand over.
    Overlap {
        /// Faces that overlap another.
        faces: usize,
    },
}

impl From<StageError> for UnwrapError {
    fn from(e: StageError) -> Self {
        match e {
            StageError::Scratch(e) => e.into(),
            StageError::Halted(_) => UnwrapError::Cancelled,
        }
    }
}

impl From<Stopped> for UnwrapError {
    fn from(_: Stopped) -> Self {
        UnwrapError::Cancelled
    }
}

impl From<PlaceError> for UnwrapError {
    fn from(e: PlaceError) -> Self {
        match e {
            PlaceError::Scratch(e) => e.into(),
            PlaceError::Stopped => UnwrapError::Cancelled,
            PlaceError::Overlap { faces } => UnwrapError::Overlap { faces },
        }
    }
}

impl From<RepairError> for UnwrapError {
    fn from(e: RepairError) -> Self {
        match e {
            RepairError::Scratch(e) => e.into(),
            RepairError::NotFinite { vertex } => UnwrapError::NotFinite { vertex },
            RepairError::BadIndex { corner } => UnwrapError::BadIndex { corner },
            RepairError::NoTriangle => UnwrapError::NoTriangle,
        }
    }
}

impl From<ScratchTooSmall> for UnwrapError {
    fn from(e: ScratchTooSmall) -> Self {
        if e.is_alarm() { UnwrapError::Cancelled } else { UnwrapError::Scratch(e) }
    }
}

impl core::fmt::Display for UnwrapError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            UnwrapError::Scratch(e) => e.fmt(f),
            UnwrapError::Cancelled => write!(f, "stopped on request"),
            UnwrapError::NoTriangle => write!(f, "the mesh holds no triangle with three different corners"),
            UnwrapError::NotFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not a number"),
            UnwrapError::BadIndex { corner } => write!(f, "corner {corner} names a vertex that does not exist"),
            UnwrapError::Overlap { faces } => write!(f, "{faces} faces of the atlas still overlap after all attempts"),
            UnwrapError::BadLength { expected, given } => write!(f, "{expected} entries expected, {given} given"),
            UnwrapError::BadTree => write!(f, "the ray hierarchy that was handed in is damaged"),
        }
    }
}

impl core::error::Error for UnwrapError {}
