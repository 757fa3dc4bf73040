//! Pictures of a mesh and its atlas, drawn by our own rays: the contact sheet.

mod atlas;
mod colour;
mod font;
mod histogram;
mod image;
mod polygons;
mod seams;
mod sheet;
mod surface;
mod view;

pub use image::Image;
pub use polygons::Drawing;
pub use sheet::{SheetOptions, sheet};
pub use surface::PictureMesh;
