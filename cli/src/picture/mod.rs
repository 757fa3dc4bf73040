//! Pictures of a mesh, its atlas and its parts, drawn by our own rays.

mod atlas;
mod colour;
pub mod curves;
mod font;
mod histogram;
mod image;
mod parts;
mod polygons;
mod seams;
mod sheet;
mod surface;
mod view;

pub use colour::{Rgb, linear, part as part_colour};
pub use image::Image;
pub use parts::PartsDrawing;
pub use polygons::Drawing;
pub use sheet::{SheetOptions, sheet};
pub use surface::PictureMesh;
