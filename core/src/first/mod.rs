//! First cuts and first maps: every component becomes disks, and every disk a map without flips.

#[cfg(test)]
mod cut_tests;
pub mod disks;
pub mod facets;
pub mod halving;
pub mod handles;
mod joining;
pub mod projection;
mod tips;
