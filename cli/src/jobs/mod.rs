//! A whole job: from the loaded mesh to the outputs in their places.
//!
//! - [`job`]: what it is asked for
//! - [`target`], `checks`: where it goes, and what can be refused before the work
//! - `unwrap`: the work

mod checks;
pub mod job;
pub mod target;
mod unwrap;
