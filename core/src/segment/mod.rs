//! Segment: from shape diameters, concave creases and inner sight to parts.

pub mod dual;
pub mod expansion;
pub mod max_flow;
pub mod mixture;
pub mod parts;
pub mod published;
pub mod tidy;
