//! The atlas of one mesh on another mesh of the same shape.
//!
//! - [`closest`]: closest points; [`source`]: the atlas that is carried over; [`mod@arcs`]: its borders
//! - [`routes`]: those borders on the other mesh; [`sheets`]: which chart each face is; [`targets`]: where its nodes go
//! - [`untangle`], [`clear`]: no face turned over, none on another
//! - [`twin_mesh`]: what needs none of that; [`report`], [`onto`]: the whole

pub mod arcs;
pub mod clear;
pub mod closest;
pub mod onto;
pub mod report;
pub mod routes;
pub mod sheets;
pub mod source;
pub mod targets;
pub mod twin_mesh;
pub mod untangle;
