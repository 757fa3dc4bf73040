//! What a cut costs: where the surface turns, what is seen, what the file and the caller say.

pub mod cost;
pub mod given;
pub mod turn;
