//! How many parts are asked for, and how many were found.

/// How many parts, and by which method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Count {
    /// As many as the shape has.
    #[default]
    Auto,
    /// This many over the whole mesh, but never fewer than its components, and from these on no more than patches (see
    /// `patches`): 400 and a quarter of the faces.
    Exactly(u32),
    /// The published method. Its parts are the connected regions of clusters, so there are at least as many.
    Published {
        /// Clusters of shape diameters, 1 to 16; None: as many as the Bayesian information criterion wants.
        clusters: Option<u32>,
        /// Weight of smoothness, at least 0.
        lambda: f64,
    },
}

impl Count {
    /// The published method with its published numbers.
    pub const PUBLISHED: Count = Count::Published { clusters: Some(3), lambda: 15.0 };
}

/// What can be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartSettings {
    /// Number of parts and method.
    pub count: Count,
    /// Seed of every random value.
    pub seed: u64,
}

/// What was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartSummary {
    /// Parts; labels are 0..parts.
    pub parts: usize,
    /// Clusters of the published method, else 0.
    pub clusters: usize,
}
