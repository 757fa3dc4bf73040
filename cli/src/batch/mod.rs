//! Many files: each by a process of its own, so that none that is bad, slow or large stops the others.
//!
//! - [`mod@items`]: the files, and what becomes of each
//! - `digest`, `record`: what was made of which bytes, kept so that a later run can skip it
//! - `admission`: as many at once as memory holds
//! - `child`, `place`: a process for a file, and its outputs put in their places
//! - [`run`]: the whole

mod admission;
mod child;
mod digest;
pub mod items;
mod place;
mod record;
pub mod run;
