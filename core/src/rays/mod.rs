//! Rays: hierarchy, casting, exposure.

pub mod bvh;
