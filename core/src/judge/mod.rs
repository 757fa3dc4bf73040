//! Judging any UV map, whoever made it.

pub mod agreement;
pub mod assignment;
pub mod atlas;
pub mod charts;
pub mod coverage;
pub mod cut_discrepancy;
pub mod distortion;
pub mod edges;
pub mod facing;

pub mod input;
pub mod measure;

pub mod seams;
pub mod stacks;
pub mod wedges;
