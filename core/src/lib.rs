//! seamwright-core: from a triangle mesh to a UV atlas, in the caller's memory.
//!
//! The rooms, lowest first; docs/ARCHITECTURE.md says which may import which:
//! - [`base`]: memory, workers, progress, numbers; [`mesh`]: views, topology, repair, decimation; [`plane`]: grid, overlap, hulls;
//!   [`solve`]: energy, Newton's method, sparse systems
//! - [`rays`]: exposure and shape diameter; [`parts`]: labels of parts; [`price`]: what a cut costs
//! - [`charts`]: a surface with cuts, and work on its charts; [`first`]: the least cuts and first maps; [`carry`]: cuts of a
//!   coarse mesh carried over; [`search`]: seams; [`pack`]: charts into the square; [`finish`]: onto the grid
//! - [`learn`]: maps learned of one mesh; [`judge`]: figures of any map
//! - [`transfer`]: the atlas of one mesh on another mesh of the same shape
//! - [`pipeline`]: joins the stages
//!
//! A pyramid on a square, unwrapped in memory that the caller owns:
//! ```
//! use glam::{DVec2, DVec3};
//! use seamwright_core::base::progress::Silent;
//! use seamwright_core::base::scratch::Scratch;
//! use seamwright_core::base::workers::Serial;
//! use seamwright_core::pipeline::{Input, Output, Settings, unwrap, unwrap_need};
//! use seamwright_core::rays::binned::BinnedBuilder;
//!
//! let corner = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.5, 0.5, 1.0)];
//! let positions = corner.map(DVec3::from);
//! let corners = [0, 3, 2, 1, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4];
//! let polygon_start = [0, 4, 7, 10, 13, 16]; // a quad and four triangles
//! let (input, settings) = (Input::new(&positions, &corners, &polygon_start), Settings::default());
//!
//! let (mut corner_uv, mut polygon_chart, mut exposure) = ([DVec2::ZERO; 16], [0; 5], [0.0; 5]);
//! let output = Output { corner_uv: &mut corner_uv, polygon_chart: &mut polygon_chart, exposure: &mut exposure };
//! let mut memory = vec![0; unwrap_need(&input, &settings, &BinnedBuilder)];
//! let scratch = Scratch::new(&mut memory);
//! let report = unwrap(output, &input, &settings, &BinnedBuilder, scratch, &Serial, &mut Silent)?;
//!
//! assert_eq!((report.flipped, report.overlapping), (0, 0));
//! assert!(report.distortion <= settings.distortion);
//! assert!(corner_uv.iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0));
//! # Ok::<(), seamwright_core::pipeline::UnwrapError>(())
//! ```
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
pub mod transfer;
