//! What zipping may do.

/// Which paths may be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// All.
    All,
    /// Those between a sliver and another chart.
    Slivers,
    /// Those inside a chart, at any time: overlaps may be there that are parted later.
    Slits,
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
