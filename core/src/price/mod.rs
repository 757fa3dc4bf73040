//! What a cut costs.

pub mod cost;
