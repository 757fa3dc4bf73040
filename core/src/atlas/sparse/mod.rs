//! Direct solver for the sparse positive definite systems of planar meshes: two unknowns a node.
//!
//! - `dissection`: the order of elimination, from the graph alone
//! - `multifrontal`: the factor, and solutions with it
//! - `dense`: the one dense kernel below

mod dense;
mod dissection;
mod multifrontal;

pub use dissection::Symbolic;
pub use multifrontal::{Factor, FrontMatrix};
