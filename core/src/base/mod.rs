//! The lowest room: memory, workers, progress, numbers.

pub mod buckets;
pub mod eight;
pub mod heap;
pub mod listing;
pub mod pace;
pub mod progress;
pub mod random;
pub mod real;
pub mod room;
pub mod scratch;
pub mod slices;
pub mod sort;
pub mod stack;
pub mod union_find;
pub mod vector;
pub mod workers;
