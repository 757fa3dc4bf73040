//! Reverse-mode tape: a static graph, recorded once, replayed forward and backward without allocation or recursion.
//!
//! Values and gradients lie in two slices of the caller, laid out while recording; parameters come first where they are
//! recorded first. Every operation is a struct with its forward and backward side by side ([`operation::Operation`]) and an entry in
//! the finite-difference table of `difference_tests.rs`, whose completeness a test asserts.
//! An operation's output lies behind its inputs, so one split of the slice separates what is read from what is written.
//! Backward begins at seeds (output, weight). A gradient that nothing has reached is neither read nor cleared: whole
//! branches cost nothing when their seed is missing. Generic over `Float`: f32 trains, f64 checks.
//!
//! All operations stand in [`ops`]; what each records is a method of [`recording::Recording`] beside it.
//! Limits: [`recording::MAX_OPERATIONS`] and [`recording::MAX_VARS`]; recording beyond them is a mistake of our own code, an index out of bounds.
//! Shapes that do not agree are one too: which there are depends on settings alone, so debug builds check them.

pub mod affine;
pub mod angles;
mod case_tests;
pub mod cosine;
mod difference_tests;
pub mod distortion;
pub mod eigenvalues;
pub mod gap;
pub mod means;
pub mod nearest;
pub mod normalise;
pub mod operation;
pub mod ops;
pub mod recording;
pub mod repel;
mod replay_tests;
pub mod seam;
pub mod shape;
pub mod var;
