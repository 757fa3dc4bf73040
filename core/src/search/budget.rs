//! What a search may spend.

/// What the search may spend.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub distortion: f64,
    /// Whether a chart may be bulky: where charts are parts, a part should be one.
    pub bulky: bool,
    /// Whether a piece stays one chart; larger ones than can be walled only become few.
    pub whole: bool,
    /// Trials beyond those of any search, on the mesh or, where it is decimated, on the coarse mesh.
    pub renewals: u32,
    /// Seed of the places of trials.
    pub seed: u64,
    /// Whether the search may be told to end early: then it keeps a copy of its last mark.
    pub ends_early: bool,
}
