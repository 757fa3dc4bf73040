//! Direct solver for the sparse positive definite systems of planar meshes: two unknowns a node.
//!
//! - `dissection`: the order of elimination, from the graph alone
//! - `boughs`: which parts of it are worked on side by side, and what is kept of them
//! - `multifrontal`: factor and solution along the tree
//! - `front_matrix`: one `front`: assembly, elimination, and the way back
//! - `dense`: the one dense kernel below

mod boughs;
mod dense;
pub mod dissection;
mod front;
pub mod front_matrix;
pub mod multifrontal;
