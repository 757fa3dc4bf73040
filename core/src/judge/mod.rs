//! Judging any UV map, whoever made it.

pub mod atlas;
pub mod charts;
pub mod coverage;
pub mod distortion;

pub mod input;
pub mod measure;

pub mod seams;
pub mod wedges;
