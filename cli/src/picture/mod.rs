//! Pictures of a mesh, its atlas and its parts, drawn by our own rays.

mod atlas;
pub mod curves;
pub mod drawing;
mod font;
mod histogram;
mod image;
pub mod parts;
mod seams;
mod sheet;
mod surface;
mod view;
