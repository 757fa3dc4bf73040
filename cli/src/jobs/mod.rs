//! A whole job: from the loaded mesh to the outputs in their places.
//!
//! - [`job`]: what it is asked for
//! - `checks`: what can be refused before the work
//! - `unwrap`: the work

mod checks;
pub mod job;
mod unwrap;
