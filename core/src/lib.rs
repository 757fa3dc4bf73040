//! seamwright-core: from a triangle mesh to a UV atlas, in the caller's memory.
//!
//! The rooms, lowest first; docs/ARCHITECTURE.md says which may import which:
//! - [`base`]: memory, workers, progress, numbers; [`mesh`]: views, topology, repair, decimation; [`plane`]: grid, overlap, hulls;
//!   [`solve`]: energy, Newton's method, sparse systems
//! - [`rays`]: exposure and shape diameter; [`parts`]: labels of parts; [`price`]: what a cut costs
//! - [`charts`]: a surface with cuts, and work on its charts; [`first`]: the least cuts and first maps; [`carry`]: cuts of a
//!   coarse mesh carried over; [`search`]: seams; [`pack`]: charts into the square; [`finish`]: onto the grid
//! - [`learn`]: maps learned of one mesh; [`judge`]: figures of any map
//! - [`pipeline`]: joins the stages
#![no_std]
#![warn(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod base;
pub mod carry;
pub mod charts;
pub mod finish;
pub mod first;
pub mod judge;
pub mod learn;
pub mod mesh;
pub mod pack;
pub mod parts;
pub mod pipeline;
pub mod plane;
pub mod price;
pub mod rays;
pub mod search;
pub mod solve;
