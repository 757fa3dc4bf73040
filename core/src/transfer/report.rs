//! Where a transfer writes, what it has done, and why there may be no atlas.

use crate::base::progress::Stopped;
use crate::base::scratch::ScratchTooSmall;
use crate::mesh::repair::RepairError;
use glam::DVec2;

/// Where the atlas is written.
pub struct TransferOutput<'o> {
    /// UV of each corner.
    pub corner_uv: &'o mut [DVec2], // (c)
    /// Chart of the source that each polygon belongs to, or `NONE`.
    pub polygon_chart: &'o mut [u32], // (p)
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransferReport {
    /// Charts of the source.
    pub source_charts: usize,
    /// Those of them that the mesh has.
    pub charts: usize,
    /// Pieces that hang together in UV: as many as charts, unless some fell apart; not counted where UVs were copied.
    pub regions: usize,
    /// Faces of the source that are turned over against the rest of their chart.
    pub source_flipped: usize,
    /// Faces of the source that overlap another.
    pub source_overlapping: usize,
    /// Faces without positive area on the grid.
    pub flipped: usize,
    /// Faces that overlap another on the grid; where UVs were copied, of the source.
    pub overlapping: usize,
    /// Those of them that belong to small pieces, as flaps of no thickness do.
    pub small: usize,
    /// Faces that would be turned over or overlap where the source says they belong, and their neighbours that moved with them.
    pub moved: usize,
    /// Share of the surface whose UVs are within two texels of the source's.
    pub within_two_texels: f64,
    /// Mean distance of the mesh's faces from the source, in the user's units.
    pub distance: f64,
    /// Largest side of the source's box, in the user's units.
    pub extent: f64,
    /// Whether all polygons of the mesh are polygons of the source, and their UVs were copied as they are.
    pub copied: bool,
}

/// Why there is no atlas. Outputs are unspecified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransferError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// The progress callback asked to stop.
    Stopped,
    /// The mesh with the atlas cannot be worked on.
    Source(RepairError),
    /// The mesh that the atlas goes to cannot be worked on.
    Mesh(RepairError),
    /// A corner of the source has no UV.
    NoUv {
        /// Polygon that it belongs to.
        polygon: usize,
    },
    /// The two surfaces do not lie near each other.
    Apart {
        /// Mean distance of the mesh's faces from the source, in the user's units.
        distance: f64,
        /// Largest side of the source's box.
        extent: f64,
    },
    /// The mesh faces the other way than the source.
    Reversed {
        /// Share of its area that does.
        share: f64,
    },
    /// Charts of the source lie upon one another.
    Stacked {
        /// Faces that overlap another.
        faces: usize,
        /// Faces.
        of: usize,
    },
    /// An output has not one entry for each that is written to it.
    Length {
        /// Entries that would fit.
        expected: usize,
        /// Entries that were there.
        given: usize,
    },
}

impl From<ScratchTooSmall> for TransferError {
    fn from(e: ScratchTooSmall) -> Self {
        TransferError::Scratch(e)
    }
}

impl From<Stopped> for TransferError {
    fn from(_: Stopped) -> Self {
        TransferError::Stopped
    }
}

impl core::fmt::Display for TransferError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            TransferError::Scratch(e) => e.fmt(f),
            TransferError::Stopped => write!(f, "stopped on request"),
            TransferError::Source(e) => write!(f, "the mesh with the atlas: {e}"),
            TransferError::Mesh(e) => e.fmt(f),
            TransferError::NoUv { polygon } => write!(f, "polygon {polygon} of the mesh with the atlas has no UVs"),
            TransferError::Apart { distance, extent } => {
                write!(f, "the surfaces are {distance} apart on the mean, at a size of {extent}")
            }
            TransferError::Reversed { share } => write!(f, "{:.0} % of the mesh faces the other way", 100.0 * share),
            TransferError::Stacked { faces, of } => write!(f, "{faces} of {of} faces of the atlas lie upon others"),
            TransferError::Length { expected, given } => write!(f, "{expected} entries expected, {given} given"),
        }
    }
}

impl core::error::Error for TransferError {}
