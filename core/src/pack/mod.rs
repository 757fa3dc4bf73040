//! Packing: charts into the unit square.
//!
//! - [`layout`]: the public entry and the order of the steps; [`flat_charts`], [`settings`], [`placement`]: what goes in and out
//! - `outline`: borders, hulls and areas of the charts, in a common unit
//! - `grid`: one cell a chart; `shelf`: bounding boxes in rows; `square`: one chart, or none
//! - `mask`, `poles`, `board`, `fill`: shapes as bit masks, placed bottom-left on a raster
//! - `field`, `separate`: shapes as distance fields, overlap minimised in a shrinking square
//! - `clearance`: the exact check of distances between borders

mod board;
mod body;
mod clearance;
mod field;
mod fill;
pub mod flat_charts;
mod grid;
pub mod layout;
mod mask;
mod outline;
pub mod placement;
mod poles;
mod separate;
pub mod settings;
mod shelf;
mod square;
