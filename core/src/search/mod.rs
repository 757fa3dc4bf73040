//! The search for seams: cuts that grow towards distortion, part what overlaps, and are glued and zipped again.

pub mod beside;
pub mod budget;
pub mod by_proxy;
pub mod closing;
pub mod compact;
pub mod direct;
pub mod extend;
pub mod glue;
pub mod goal;
pub mod renewal;
pub mod rounds;
pub mod ruin;
pub mod seams;
pub mod split;
pub mod zip;
#[cfg(test)]
mod zip_tests;
