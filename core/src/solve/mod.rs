//! Maps of one piece of surface: its energy, first maps, Newton's method, and the sparse systems below them.

pub mod bound;
mod convex;
pub mod energy;
pub mod flatten;
pub mod levels;
pub mod modes;
pub mod piece;
pub mod quad;
pub mod quads;
pub mod relax;
pub mod sparse;
mod symmetric;
pub mod system;
mod walls;
