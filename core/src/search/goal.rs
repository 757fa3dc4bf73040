//! What zipping may do.

/// Paths that are tried at the most; each costs a relaxation of its chart.
const TRIES: usize = 24;
/// Of ends: 24 gain no more.
const END_TRIES: usize = 10;

/// Which paths may be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// All.
    All,
    /// Those between a sliver and another chart.
    Slivers,
    /// Those inside a chart, at any time: overlaps may be there that are parted later.
    Slits,
    /// Of those with a free end half, from there on, and of what fails half again.
    Ends,
}

impl Which {
    /// How many are tried at the most.
    pub fn tries(self) -> usize {
        if self == Self::Ends { END_TRIES } else { TRIES }
    }
}

/// What zipping may do.
#[derive(Clone, Copy)]
pub struct Goal {
    /// Mean symmetric Dirichlet energy over 4 at the end.
    pub distortion: f64,
    /// Symmetric Dirichlet energy of a face that was below.
    pub worst: f64,
    /// Whether a chart may become bulky.
    pub bulky: bool,
    /// Which paths are tried.
    pub which: Which,
}
