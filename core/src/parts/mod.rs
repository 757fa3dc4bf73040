//! Parts: from shape diameters, concave creases and inner sight to labels.

pub mod affinity;
pub mod border;
pub mod by_sight;
pub mod dual;
pub mod expansion;
pub mod max_flow;
pub mod merging;
pub mod mixture;
pub mod patches;
pub mod published;
pub mod segmentation;
pub mod settings;
pub mod surface;
pub mod tidy;
mod turned_tests;
