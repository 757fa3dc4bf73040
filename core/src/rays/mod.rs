//! Rays: hierarchy, casting, directions, exposure, shape diameter.

pub mod binned;
pub mod bvh;
pub mod cast;
pub mod diameter;
pub mod directions;
pub mod exposure;
pub mod fan;
mod intersect;
mod lanes;
mod nearest;
mod wide;
