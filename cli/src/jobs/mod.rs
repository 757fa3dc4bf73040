//! A whole job: from the loaded mesh to the outputs in their places.
//!
//! - [`job`]: what it is asked for
//! - [`target`], `checks`: where it goes, and what can be refused before the work
//! - `sets`: what shares an atlas
//! - `hints`: what may not be meant so
//! - `missed`: why a bound was not kept
//! - [`outputs`]: that they fall on nothing, and appear together
//! - `unwrap`: the work

mod checks;
mod hints;
pub mod job;
mod missed;
pub mod outputs;
mod sets;
pub mod target;
mod unwrap;
