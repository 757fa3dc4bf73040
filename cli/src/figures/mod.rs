//! Figures of any UV-mapped mesh, whatever tool made it.
//!
//! - [`measure`], [`record`], [`table`]: core's judge on a file's mesh; its figures for scripts and for people
//! - [`exposure`], [`sampled`]: exposure as evaluators sample it
//! - [`agreement`]: how far charts or labels agree with other partitions

pub mod agreement;
mod cells;
pub mod exposure;
pub mod measure;
pub mod record;
pub mod sampled;
pub mod table;
