//! Direct solver for the sparse positive definite systems of planar meshes: two unknowns a node.
//!
//! - `dissection`: the order of elimination, from the graph alone
//! - `boughs`: which parts of it are worked on side by side, and what is kept of them
//! - `multifrontal`: factor and solution along the tree
//! - `front`: one front: assembly, elimination, and the way back
//! - `dense`: the one dense kernel below

mod boughs;
mod dense;
mod dissection;
mod front;
mod multifrontal;

pub use dissection::Symbolic;
pub use front::FrontMatrix;
pub use multifrontal::Factor;
