//! Pictures of a mesh, its atlas and its parts, drawn by our own rays.
//!
//! - [`drawing`], [`parts`], [`curves`]: what is drawn: an atlas, parts, losses
//! - `sheet`, `layout`: the contact sheet, and what all sheets have in common
//! - `surface`, `seams`, `view`, `atlas`, `histogram`: the mesh as pictures need it, and the panels
//! - `font`, `image`: words and pixels

mod atlas;
pub mod curves;
pub mod drawing;
mod font;
mod histogram;
mod image;
mod layout;
pub mod parts;
mod seams;
mod sheet;
mod surface;
mod view;
