//! seamwright-core: from a triangle mesh to a UV atlas, in the caller's memory.
//!
//! The floors, lowest first; a module imports only from floors below its own:
//! - [`base`]: memory, workers, progress, numbers
//! - [`mesh`]: views, topology, repair
//! - [`price`]: what a cut costs
//! - [`rays`], [`segment`], [`learn`], [`atlas`], [`judge`]: the stages; none imports another
//! - [`pipeline`]: joins the stages
#![no_std]
#![warn(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod atlas;
pub mod base;
pub mod judge;
pub mod learn;
pub mod mesh;
pub mod pipeline;
pub mod price;
pub mod rays;
pub mod segment;
