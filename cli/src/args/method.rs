//! What makes the map, as asked.

use clap::ValueEnum;

/// What makes the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Cuts by exposure and distortion, then flattening; no training
    Exact,
    /// The same charts, mapped by a network that learns them
    Neural,
    /// As exact, with 40 further trials of seams unless --search says how many
    Hybrid,
}

impl MethodArg {
    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            MethodArg::Exact => "exact",
            MethodArg::Neural => "neural",
            MethodArg::Hybrid => "hybrid",
        }
    }
}
