//! Figures of any UV-mapped mesh, whatever tool made it.

pub mod agreement;
pub mod exposure;
pub mod measure;
