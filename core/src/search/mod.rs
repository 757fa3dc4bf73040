//! The search for seams: cuts that grow towards distortion, part what overlaps, and are glued and zipped again.

pub mod compact;
pub mod extend;
pub mod glue;
pub mod seams;
pub mod split;
pub mod zip;
