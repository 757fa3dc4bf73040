//! What every room needs: how the command ends, and colours.

pub mod colour;
pub mod failure;
