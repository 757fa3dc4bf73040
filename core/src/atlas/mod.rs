//! Atlas: cuts, flattening, seams, packing.

pub mod pack;
