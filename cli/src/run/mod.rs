//! Core's pipeline with the memory, threads, ray hierarchy and progress that a desktop has.
//!
//! - [`atlas`], [`parts`], [`transferred`]: what core makes of a loaded mesh
//! - `memory`, [`threads`], [`hierarchy`]: what it works with
//! - [`progress`], [`stop`], [`deadline`], `errors`: what the user sees of it, says to it and hears of its failures

pub mod atlas;
pub mod deadline;
mod errors;
pub mod hierarchy;
pub mod memory;
pub mod parts;
pub mod progress;
pub mod stop;
pub mod threads;
pub mod transferred;
