//! What every room needs: how the command ends, colours, counts in words.

pub mod colour;
pub mod counted;
pub mod failure;
