//! Cuts of a decimated mesh, carried over to the mesh it came from.

pub mod detour;
pub mod proxy;
pub mod slide;
pub mod transfer;
