//! What can be wrong with an atlas.

use core::fmt;

/// A rule that a face breaks. Faces are counted from 0, as every report counts them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A corner has no UV.
    Unmapped(u32),
    /// A corner's UV is no finite number.
    NotFinite(u32),
    /// Its outline runs clockwise, or crosses itself, so that no triangles that face the viewer tile it.
    Flipped(u32),
    /// It has an area in space and none in UV.
    Empty(u32),
    /// It overlaps another face.
    Overlap(u32, u32),
    /// It reaches out of the unit square.
    Outside(u32),
    /// It is closer to a face of another chart than the gutter is wide: how far in texels.
    Gutter(u32, u32, f64),
    /// The input's face is not there: another one, or none, stands in its place.
    Missing(u32),
    /// It has other corners than the input's face.
    Changed(u32),
    /// The input has no such face.
    Added(u32),
}

impl Fault {
    /// The face that breaks the rule; of two, the first.
    pub fn face(self) -> u32 {
        match self {
            Fault::Unmapped(f) | Fault::NotFinite(f) | Fault::Flipped(f) | Fault::Empty(f) => f,
            Fault::Overlap(f, _) | Fault::Outside(f) | Fault::Gutter(f, _, _) => f,
            Fault::Missing(f) | Fault::Changed(f) | Fault::Added(f) => f,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Unmapped(face) => write!(f, "face {face}: a corner has no UV"),
            Fault::NotFinite(face) => write!(f, "face {face}: a UV is no finite number"),
            Fault::Flipped(face) => write!(f, "face {face}: flipped, or folded over itself"),
            Fault::Empty(face) => write!(f, "face {face}: has an area on the mesh and none in UV"),
            Fault::Overlap(face, other) => write!(f, "face {face}: overlaps face {other}"),
            Fault::Outside(face) => write!(f, "face {face}: reaches out of the unit square"),
            Fault::Gutter(face, other, texels) => {
                write!(f, "face {face}: {texels:.4} texels from face {other} of another chart")
            }
            Fault::Missing(face) => write!(f, "face {face} of the input: not there"),
            Fault::Changed(face) => write!(f, "face {face}: other corners than the input's"),
            Fault::Added(face) => write!(f, "face {face}: not in the input"),
        }
    }
}
