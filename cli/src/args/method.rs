//! What makes the map, as asked.

use clap::ValueEnum;

/// What makes the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Cuts by exposure and distortion, then flattening; no training
    Exact,
    /// A network's own map of each piece, cut where it tears; charts may overlap, which is reported
    Neural,
    /// Networks say where seams hide, the exact stages make the atlas
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
