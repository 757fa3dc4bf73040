//! The atlas of one mesh on another mesh of the same shape.
//!
//! - [`closest`]: closest points; [`source`]: the atlas that is carried over; [`mod@arcs`]: its borders
//! - [`routes`]: those borders on the other mesh; [`sheets`]: which chart each face is; [`strays`]: what has no place there; [`targets`]:
//!   where nodes go
//! - [`untangle`], [`clear`]: no face turned over, none on another; [`give_back`]: what gave way without need; [`carried_map`]: the map on the grid
//! - [`mesh_and_atlas`]: what these read; [`lay`]: these together; [`twin_mesh`]: what needs none of that; [`report`], [`onto`]: the whole

pub mod arcs;
pub mod carried_map;
pub mod clear;
pub mod closest;
pub mod give_back;
pub mod lay;
pub mod mesh_and_atlas;
pub mod onto;
pub mod report;
pub mod routes;
pub mod sheets;
pub mod source;
pub mod strays;
pub mod targets;
pub mod twin_mesh;
pub mod untangle;
