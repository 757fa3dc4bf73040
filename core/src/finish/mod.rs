//! The way onto the grid of the written UVs: charts settled, snapped, set apart where nothing else helps, and what was dropped;
//! [`place::place`] joins them.

pub mod apart;
pub mod fill;
pub mod order;
pub mod packing_cuts;
pub mod place;
pub mod settle;
pub mod snap;
pub mod strips;
mod texels;
pub mod upright;
