//! The sheet of a segmented mesh: its parts in colours and its shape diameter, from five sides.
//!
//! Diameter runs from thin (dark) to thick (light) on a logarithmic scale. The same input gives the same bytes.

use super::image::Image;
use super::layout::{CAPTION, GAP, HEADER, cameras, pixel_width};
use super::seams::Lines;
use super::surface::{PictureMesh, PictureSurface};
use super::view::{self, Look};
use super::{font, view::Camera};
use crate::base::colour::{INK, PAPER};
use crate::mesh::polygons::Mesh;
use crate::mesh::triangles::of_mesh;
use seamwright_core::base::real::ln;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_core::rays::cast::Scene;

/// Side of a view in pixels.
const TILE: usize = 360;

/// What the sheet shows.
pub struct PartsDrawing<'a> {
    /// Printed above.
    pub title: String,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Part of each polygon.
    pub part: &'a [u32], // (p)
    /// Shape diameter of each polygon.
    pub diameter: &'a [f32], // (p)
}

impl PartsDrawing<'_> {
    /// Draws it as PNG. The same bytes with any workers.
    pub fn png(self, workers: &dyn Workers) -> Vec<u8> {
        let mesh = self.mesh;
        let found = of_mesh(mesh);
        let triangles: Vec<[u32; 3]> = found.iter().map(|(_, t)| t.map(|c| mesh.corners[c as usize])).collect();
        let part: Vec<u32> = found.iter().map(|(p, _)| self.part[*p]).collect();
        let thickness = self.thickness();
        let picture = |values: &[f32]| {
            let positions = &mesh.positions;
            let (chart, exposure) = (Some(&part[..]), Some(values));
            PictureSurface::new(&PictureMesh { positions, triangles: &triangles, corner_uv: None, chart, exposure })
        };
        let (even, thick) = (picture(&vec![1.0; mesh.positions.len()]), picture(&thickness));
        let mut bytes = vec![0; Scene::need(even.faces.len(), &BinnedBuilder)];
        let scene = Scene::new(&even.points, &even.faces, &BinnedBuilder, &mut Scratch::new(&mut bytes))
            .expect("the surface's faces name its points, and the memory is as asked");
        let cameras = cameras(false);
        let pixel = pixel_width(&even, &cameras, TILE);
        let lines = Lines::new(&even, pixel);
        let tile = |surface: &PictureSurface, camera: &Camera, row: usize| {
            let exposure = surface.exposure.as_deref().unwrap_or_default();
            let look = Look { surface, exposure, scene: &scene, lines: &lines, cells: 1.0 };
            view::render(&look, camera, TILE, pixel, workers).into_iter().map(move |p| p[row])
        };
        let step = [TILE + GAP, TILE + CAPTION + GAP];
        let mut image = Image::new(GAP + cameras.len() * step[0], HEADER + 2 * step[1], PAPER);
        font::write(&mut image, &self.title, [GAP, 20], 3, INK);
        for (row, (name, surface)) in [("PARTS", &even), ("SHAPE DIAMETER", &thick)].into_iter().enumerate() {
            for (column, camera) in cameras.iter().enumerate() {
                let at = [GAP + column * step[0], HEADER + row * step[1]];
                if column == 0 {
                    font::write(&mut image, name, [at[0], at[1] + 6], 2, INK);
                }
                image.paste([at[0], at[1] + CAPTION], TILE, tile(surface, camera, row));
            }
        }
        image.png()
    }

    /// The diameter at each vertex, the mean of its polygons', on a logarithmic scale from 0 to 1.
    fn thickness(&self) -> Vec<f32> {
        let (mut sum, mut count) = (vec![0.0f32; self.mesh.positions.len()], vec![0.0f32; self.mesh.positions.len()]);
        for (corners, diameter) in self.mesh.polygons().zip(self.diameter) {
            for v in &self.mesh.corners[corners] {
                sum[*v as usize] += diameter;
                count[*v as usize] += 1.0;
            }
        }
        let mean: Vec<f32> = sum.iter().zip(&count).map(|(s, n)| s / n.max(1.0)).collect();
        let known = || mean.iter().copied().filter(|d| *d > 0.0).map(ln);
        let (low, high) = (known().fold(f32::INFINITY, f32::min), known().fold(f32::NEG_INFINITY, f32::max));
        let range = (high - low).max(1e-6);
        mean.into_iter().map(|d| if d > 0.0 { (ln(d) - low) / range } else { 0.0 }).collect()
    }
}
