//! Atlas: cuts, flattening, seams, packing.

pub mod apart;
pub mod bound;
pub mod charts;
pub mod compact;
pub mod cut;
#[cfg(test)]
mod cut_tests;
pub mod energy;
pub mod extend;
pub mod flatten;
pub mod glue;
pub mod halving;
pub mod pack;
mod patch;
pub mod pieces;
pub mod proxy;
pub mod relax;
pub mod seams;
pub mod settle;
pub mod slide;
pub mod snap;
pub mod sparse;
pub mod split;
pub mod surface;
pub mod tears;
pub mod transfer;
mod walls;
pub mod wedge_paths;
pub mod zip;
