//! One orthographic view of the surface: rays once a sample, shaded in several ways.

use super::seams::Lines;
use super::surface::PictureSurface;
use crate::base::colour::{self, PAPER, SEAM, linear, srgb};
use glam::{DVec2, Vec2, Vec3};
use seamwright_core::base::workers::{Workers, for_each_chunk};
use seamwright_core::mesh::view::NONE;
use seamwright_core::rays::cast::{Ray, Scene};

/// Samples a pixel and axis.
pub const SAMPLES: usize = 2;
/// Ways of shading, in the order of the sheet's rows.
pub const ROWS: [&str; 4] = ["CHARTS", "EXPOSURE", "SEAMS", "CHECKERBOARD"];
/// Cameras stand this far from the centre; the mesh lies within sqrt(3).
const DISTANCE: f32 = 4.0;
/// Grey of clay and of faces without UV.
const CLAY: [u8; 3] = [196, 199, 204];

/// Where a view looks from.
#[derive(Clone, Copy)]
pub struct Camera {
    pub name: &'static str,
    pub right: Vec3,
    pub up: Vec3,
}

impl Camera {
    /// Into the picture.
    fn ahead(&self) -> Vec3 {
        self.up.cross(self.right)
    }

    fn project(&self, p: Vec3) -> Vec2 {
        Vec2::new(p.dot(self.right), p.dot(self.up))
    }

    /// Least and greatest coordinates of the projected points.
    pub fn bounds(&self, points: impl Iterator<Item = Vec3>) -> (Vec2, Vec2) {
        let start = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (low, high) = points.map(|p| self.project(p)).fold(start, |(l, h), p| (l.min(p), h.max(p)));
        if low.x <= high.x { (low, high) } else { (Vec2::ZERO, Vec2::ZERO) }
    }
}

/// What a sample sees.
#[derive(Clone, Copy)]
struct ViewSample {
    face: u32, // NONE: the background
    weights: [f32; 3],
    is_seam: bool,
}

/// What is drawn, and how the checkerboard lies on it.
pub struct Look<'a> {
    pub surface: &'a PictureSurface,
    pub exposure: &'a [f32], // (n)
    pub scene: &'a Scene<'a>,
    pub lines: &'a Lines,
    pub cells: f64, // of the checkerboard along the unit square's side
}

/// Renders tiles of `size` pixels a side, one for each of [`ROWS`]; `pixel` is a pixel's width on the surface.
pub fn render(look: &Look, camera: &Camera, size: usize, pixel: f32, workers: &dyn Workers) -> Vec<[[u8; 3]; 4]> {
    let (low, high) = camera.bounds(look.surface.faces.iter().flatten().map(|v| look.surface.points[*v as usize]));
    let centre = (low + high) * 0.5;
    let mut pixels = vec![[[0; 3]; 4]; size * size];
    for_each_chunk(workers, &mut pixels, size, &|row, pixels| {
        for (column, out) in pixels.iter_mut().enumerate() {
            let mut sum = [Vec3::ZERO; 4];
            for s in 0..SAMPLES * SAMPLES {
                let place = |at: usize, s: usize| at as f32 + (s as f32 + 0.5) / SAMPLES as f32 - size as f32 * 0.5;
                let at = centre + Vec2::new(place(column, s % SAMPLES), -place(row, s / SAMPLES)) * pixel;
                let light = shade(look, camera, &see(look, camera, at, pixel), row as f32 / size as f32);
                (0..4).for_each(|k| sum[k] += light[k]);
            }
            *out = sum.map(|light| srgb(light / (SAMPLES * SAMPLES) as f32));
        }
    });
    pixels
}

fn see(look: &Look, camera: &Camera, at: Vec2, pixel: f32) -> ViewSample {
    let ray =
        Ray { origin: camera.right * at.x + camera.up * at.y - camera.ahead() * DISTANCE, direction: camera.ahead() };
    match look.scene.closest(&ray) {
        None => ViewSample { face: NONE, weights: [0.0; 3], is_seam: false },
        Some(hit) => {
            let corners = look.surface.faces[hit.face as usize].map(|v| look.surface.points[v as usize]);
            let point = corners[0] * hit.weights[0] + corners[1] * hit.weights[1] + corners[2] * hit.weights[2];
            ViewSample { face: hit.face, weights: hit.weights, is_seam: look.lines.near(point, pixel) }
        }
    }
}

/// Linear light for each of [`ROWS`].
fn shade(look: &Look, camera: &Camera, sample: &ViewSample, height: f32) -> [Vec3; 4] {
    if sample.face == NONE {
        return [linear(PAPER) * (1.0 - 0.12 * height); 4];
    }
    let face = sample.face as usize;
    let mix = |values: [f32; 3]| (0..3).map(|i| values[i] * sample.weights[i]).sum::<f32>();
    let normals = look.surface.corner_normals[face];
    let normal = Vec3::from_array([0, 1, 2].map(|k| mix(normals.map(|n| n[k])))).normalize_or_zero();
    let inside = normal.dot(camera.ahead()) > 0.2; // past silhouettes' interpolated normals
    let normal = if inside { -normal } else { normal };
    let exposure = mix(look.surface.faces[face].map(|v| look.exposure[v as usize]));
    let key = (camera.up * 0.62 - camera.right * 0.45 - camera.ahead() * 0.64).normalize();
    let lambert = normal.dot(key).max(0.0);
    let fill = normal.dot(-camera.ahead()).max(0.0);
    let form = (0.16 + 0.62 * lambert + 0.30 * fill) * if inside { 0.45 } else { 1.0 };
    let light = form * (0.35 + 0.65 * exposure);
    let chart = look.surface.chart[face];
    let chart_colour = if chart == NONE { linear(CLAY) } else { colour::chart(chart) };
    let charts = if sample.is_seam { chart_colour * 0.35 } else { chart_colour };
    let seams = if sample.is_seam { linear(SEAM) * (0.55 + 0.6 * form) } else { linear(CLAY) * light };
    let board = match &look.surface.uv {
        Some(uv) if uv[face][0].is_finite() => {
            checker((0..3).map(|i| uv[face][i] * sample.weights[i] as f64).sum::<DVec2>(), look.cells)
        }
        _ => linear(CLAY),
    };
    let dark = linear(colour::exposure(exposure)) * (0.6 + 0.4 * form) * if inside { 0.6 } else { 1.0 };
    [charts * light * 1.12, dark, seams, board * light * 1.12]
}

/// A board whose hue follows u, whose shade follows v, with an arrowhead towards +v in every light cell.
fn checker(uv: DVec2, cells: f64) -> Vec3 {
    let at = uv * cells;
    let (cell, inside) = (at.floor(), at - at.floor());
    let block = (uv * 8.0).floor() / 8.0;
    let light = (cell.x + cell.y).rem_euclid(2.0) < 1.0;
    let arrow = (0.22..0.78).contains(&inside.y) && (inside.x - 0.5).abs() < 0.5 * (0.78 - inside.y);
    let shade = 0.80 + 0.18 * block.y.rem_euclid(1.0) as f32;
    let (saturation, value) = if light != (light && arrow) { (0.16, 1.0) } else { (0.52, shade * 0.82) };
    linear(colour::from_hue(block.x.rem_euclid(1.0) as f32, saturation, value))
}
