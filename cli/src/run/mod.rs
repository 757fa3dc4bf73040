//! Core's pipeline with the memory, threads, ray hierarchy and progress that a desktop has.

pub mod atlas;
pub mod hierarchy;
pub mod parts;
pub mod progress;
pub mod threads;
