//! A whole job: from the loaded mesh to the outputs in their places.

pub mod unwrap;
