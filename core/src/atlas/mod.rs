//! Atlas: cuts, flattening, seams, packing.
