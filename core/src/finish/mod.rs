//! The way onto the grid of the written UVs: charts settled, snapped, set apart where nothing else helps, and what was dropped.

pub mod apart;
pub mod fill;
pub mod settle;
pub mod snap;
