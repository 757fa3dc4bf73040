//! Segment: from shape diameters, concave creases and inner sight to parts.

pub mod parts;
