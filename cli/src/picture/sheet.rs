//! The contact sheet: views in columns, ways of shading in rows, the atlas and the exposure of its seams beside them.
//!
//! The same mesh and options give the same pixels with any workers.

use super::image::Image;
use super::layout::{CAPTION, GAP, HEADER, cameras, pixel_width};
use super::seams::Lines;
use super::surface::{PictureMesh, PictureSurface};
use super::view::{self, Look, ROWS};
use super::{atlas, font, histogram};
use crate::base::colour::{FAINT, INK, PAPER, Rgb};
use glam::DVec2;
use seamwright_core::base::{scratch::Scratch, workers::Workers};
use seamwright_core::judge::seams::{FLAT, SHARP, notice};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_core::rays::cast::Scene;
use seamwright_core::rays::exposure::{ExposureSettings, exposure, exposure_need};

/// Cells of the checkerboard along the mesh's largest extent: 14 pixels a cell on the default tile.
const CELLS_ACROSS: f64 = 26.0;
/// What the caller can choose.
#[derive(Clone, Debug)]
pub struct SheetOptions {
    /// Printed above; usually the file's name.
    pub title: String,
    /// Side of a view in pixels, at least 128. The sheet is about 7.2 views wide and 4.6 high.
    pub tile: usize,
    /// Exposure rays a vertex where the mesh brings no exposure.
    pub rays: usize,
    /// The mesh stands on z instead of y.
    pub z_up: bool,
}

impl Default for SheetOptions {
    fn default() -> Self {
        Self { title: String::new(), tile: 360, rays: 256, z_up: false }
    }
}

/// Draws the sheet. Whatever the mesh lacks (UVs, faces) leaves its place plain.
pub fn sheet(mesh: &PictureMesh, options: &SheetOptions, workers: &dyn Workers) -> Image {
    let tile = options.tile.clamp(128, 4096);
    let surface = PictureSurface::new(mesh);
    let mut bytes = vec![0; Scene::need(surface.faces.len(), &BinnedBuilder) + exposure_need(options.rays)];
    let mut scratch = Scratch::new(&mut bytes);
    let scene = Scene::new(&surface.points, &surface.faces, &BinnedBuilder, &mut scratch)
        .expect("the surface's faces name its points, and the memory is as asked");
    let exposure = match &surface.exposure {
        Some(given) => given.clone(),
        None => {
            let mut out = vec![0.0; surface.points.len()];
            let settings = ExposureSettings { rays: options.rays, ..Default::default() };
            exposure(&mut out, &surface.points, &surface.normals, &scene, &settings, scratch, workers)
                .expect("the memory is as asked");
            out
        }
    };
    let cameras = cameras(options.z_up);
    let pixel = pixel_width(&surface, &cameras, tile);
    let lines = Lines::new(&surface, pixel);
    let look = Look { surface: &surface, exposure: &exposure, scene: &scene, lines: &lines, cells: cells(&surface) };

    let step = [tile + GAP, tile + CAPTION + GAP];
    let side = 2 * tile + CAPTION; // of the atlas
    let panel_x = GAP + cameras.len() * step[0] + GAP;
    let mut image = Image::new(panel_x + side + GAP, HEADER + ROWS.len() * step[1] + GAP / 2, PAPER);
    font::write(&mut image, &options.title, [GAP, 20], 3, INK);
    for (column, camera) in cameras.iter().enumerate() {
        let pixels = view::render(&look, camera, tile, pixel, workers);
        for (row, name) in ROWS.iter().enumerate() {
            let at = [GAP + column * step[0], HEADER + row * step[1]];
            image.paste([at[0], at[1] + CAPTION], tile, pixels.iter().map(|p| p[row]));
            if column == 0 {
                font::write(&mut image, name, [at[0], at[1] + 6], 2, INK);
            }
            let name = format!("FROM {}", camera.name);
            let x = at[0] + tile - font::width(&name, 2);
            font::write(&mut image, &name, [x, at[1] + 6], 2, FAINT);
        }
    }
    let drawn = atlas::draw(&surface, side, workers);
    font::write(&mut image, "ATLAS", [panel_x, HEADER + 6], 2, INK);
    image.paste([panel_x, HEADER + CAPTION], side, drawn.pixels.iter().copied());
    let (used, on_seams) = vertices(&surface);
    let pick = |vertices: &[u32]| vertices.iter().map(|v| exposure[*v as usize]).collect::<Vec<_>>();
    let below = HEADER + CAPTION + side + GAP;
    let figures = figures(&surface, &exposure, &drawn);
    let figures_height = 24 * figures.len().div_ceil(2) + 8;
    let room = image.height() - GAP - below - figures_height;
    histogram::draw(&mut image, [panel_x, below], [side, room], &pick(&used), &pick(&on_seams));
    for (i, (name, value)) in figures.iter().enumerate() {
        let at = [panel_x + (i % 2) * (side / 2), below + room + 8 + 24 * (i / 2)];
        font::write(&mut image, name, at, 2, FAINT);
        let x = at[0] + side / 2 - 24 - font::width(value, 2);
        font::write(&mut image, value, [x, at[1]], 2, if value.starts_with('!') { BAD } else { INK });
    }
    image
}

/// Ink of a figure that should be 0.
const BAD: Rgb = [200, 20, 30];

/// Cells along the unit square, so that one is 1/[`CELLS_ACROSS`] of the mesh's extent on average.
fn cells(surface: &PictureSurface) -> f64 {
    let flat = surface.uv.iter().flatten().filter(|t| t[0].is_finite());
    let flat: f64 = flat.map(|t| (t[1] - t[0]).perp_dot(t[2] - t[0]).abs() * 0.5).sum();
    let cells = CELLS_ACROSS * 0.5 * (surface.area / flat).sqrt(); // the extent is 2
    if cells.is_finite() { cells.clamp(1.0, 4096.0).round() } else { 1.0 }
}

/// Vertices of faces, and those of seams.
fn vertices(surface: &PictureSurface) -> (Vec<u32>, Vec<u32>) {
    let unique = |all: &mut Vec<u32>| {
        all.sort_unstable();
        all.dedup();
    };
    let mut used: Vec<u32> = surface.faces.iter().flatten().copied().collect();
    let seams = surface.edges.iter().zip(&surface.is_seam).filter(|(_, seam)| **seam);
    let mut on_seams: Vec<u32> = seams.flat_map(|(edge, _)| *edge).collect();
    unique(&mut used);
    unique(&mut on_seams);
    (used, on_seams)
}

/// Names and values for the corner of the sheet.
fn figures(surface: &PictureSurface, exposure: &[f32], atlas: &atlas::DrawnAtlas) -> Vec<(&'static str, String)> {
    let (mut length, mut visible, mut noticed) = (0.0, 0.0, 0.0);
    let (mut between_two, mut flat, mut sharp) = (0.0, 0.0, 0.0);
    for (e, edge) in surface.edges.iter().enumerate().filter(|(e, _)| surface.is_seam[*e]) {
        let [a, b] = edge.map(|v| v as usize);
        let l = surface.points[a].as_dvec3().distance(surface.points[b].as_dvec3());
        let seen = l * 0.5 * (exposure[a] + exposure[b]) as f64;
        length += l;
        visible += seen;
        noticed += seen * surface.turn[e].map_or(1.0, notice);
        if let Some(turn) = surface.turn[e] {
            between_two += l;
            flat += if turn < FLAT { l } else { 0.0 };
            sharp += if turn > SHARP { l } else { 0.0 };
        }
    }
    let share = |part: f64| if between_two > 0.0 { part / between_two * 100.0 } else { 0.0 };
    let scale = 1.0 / surface.area.sqrt().max(f64::MIN_POSITIVE);
    let missing = surface.uv.iter().flatten().filter(|t: &&[DVec2; 3]| !t[0].is_finite()).count();
    let missing = if surface.uv.is_none() { surface.faces.len() } else { missing };
    let count = |n: usize| if n > 0 { format!("!{n}") } else { "0".into() };
    vec![
        ("TRIANGLES", surface.faces.len().to_string()),
        ("CHARTS", surface.chart_count.to_string()),
        ("SEAM LENGTH", format!("{:.2}", length * scale)),
        ("VISIBLE SEAMS", format!("{:.2}", visible * scale)),
        ("NOTICED SEAMS", format!("{:.2}", noticed * scale)),
        ("ON FLAT, ON SHARP", format!("{:.0}%, {:.0}%", share(flat), share(sharp))),
        ("UTILISATION", format!("{:.1}%", atlas.utilisation * 100.0)),
        ("OVERLAP, STACKED", format!("{:.3}%, {}", atlas.overlap * 100.0, atlas.stacked)),
        ("FLIPPED", count(atlas.flipped)),
        ("WITHOUT UV", count(missing)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use seamwright_core::base::workers::Serial;
    use std::thread;

    struct Crowd;
    impl Workers for Crowd {
        fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
            thread::scope(|s| {
                for first in 0..3 {
                    s.spawn(move || (first..count).step_by(3).for_each(task));
                }
            });
        }
    }

    /// A tent of two charts: one roof each.
    const POSITIONS: [DVec3; 6] = [
        DVec3::new(-1.0, 0.0, -1.0),
        DVec3::new(-1.0, 0.0, 1.0),
        DVec3::new(0.0, 1.0, -1.0),
        DVec3::new(0.0, 1.0, 1.0),
        DVec3::new(1.0, 0.0, -1.0),
        DVec3::new(1.0, 0.0, 1.0),
    ];
    const TRIANGLES: [[u32; 3]; 4] = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]];

    fn uv() -> [[DVec2; 3]; 4] {
        let t = |u: f64, v: f64| DVec2::new(u, v);
        [
            [t(0.0, 0.0), t(0.4, 0.0), t(0.4, 0.4)],
            [t(0.0, 0.0), t(0.4, 0.4), t(0.0, 0.4)],
            [t(0.5, 0.5), t(0.9, 0.5), t(0.9, 0.9)],
            [t(0.5, 0.5), t(0.9, 0.9), t(0.5, 0.9)],
        ]
    }

    fn mesh<'a>(corner_uv: Option<&'a [[DVec2; 3]]>) -> PictureMesh<'a> {
        PictureMesh { positions: &POSITIONS, triangles: &TRIANGLES, corner_uv, chart: None, exposure: None }
    }

    fn small() -> SheetOptions {
        SheetOptions { title: "tent".into(), tile: 128, rays: 16, ..Default::default() }
    }

    #[test]
    fn workers_change_no_pixel() {
        let uv = uv();
        assert!(sheet(&mesh(Some(&uv)), &small(), &Serial) == sheet(&mesh(Some(&uv)), &small(), &Crowd));
    }

    #[test]
    fn the_ridge_is_the_seam_and_each_roof_a_chart() {
        let uv = uv();
        let surface = PictureSurface::new(&mesh(Some(&uv)));
        assert_eq!(surface.chart_count, 2);
        assert_eq!(surface.chart, [0, 0, 1, 1]);
        let seams: Vec<_> = surface.edges.iter().zip(&surface.is_seam).filter(|(_, s)| **s).collect();
        assert_eq!(seams, [(&[2, 3], &true)]);
        let drawn = atlas::draw(&surface, 200, &Serial);
        assert_eq!((drawn.overlap, drawn.flipped), (0.0, 0));
        // Its length is 2, the area 4 sqrt 2, and it turns by 90 degrees.
        let found = figures(&surface, &[1.0; 6], &drawn);
        for (name, value) in [("VISIBLE SEAMS", "0.84"), ("NOTICED SEAMS", "0.08"), ("ON FLAT, ON SHARP", "0%, 100%")] {
            assert!(found.contains(&(name, value.to_string())), "{found:?}");
        }
        // Two squares of side 0.4; 400 samples a side put each border off by up to a sample.
        assert!((drawn.utilisation - 0.32).abs() < 0.005, "{}", drawn.utilisation);
    }

    #[test]
    fn overlap_and_flips_are_counted() {
        let mut uv = uv();
        let draw = |uv: &[[DVec2; 3]]| atlas::draw(&PictureSurface::new(&mesh(Some(uv))), 64, &Serial);
        uv[2] = uv[0];
        uv[3] = [uv[1][1], uv[1][0], uv[1][2]];
        let drawn = draw(&uv);
        assert!(drawn.overlap > 0.9 && drawn.stacked == 0);
        uv[3] = uv[1];
        let drawn = draw(&uv);
        assert_eq!((drawn.overlap, drawn.stacked), (0.0, 1), "charts that coincide");
        let flipped = |uv: &[[DVec2; 3]]| {
            let surface =
                PictureSurface { chart: vec![0, 0, 1, 1], chart_count: 2, ..PictureSurface::new(&mesh(Some(uv))) };
            atlas::draw(&surface, 64, &Serial).flipped
        };
        uv[2] = [DVec2::new(0.5, 0.5), DVec2::new(0.9, 0.5), DVec2::new(0.9, 0.9)];
        uv[3] = [DVec2::new(0.5, 0.9), DVec2::new(0.6, 0.9), DVec2::new(0.6, 1.0)];
        assert_eq!(flipped(&uv), 0);
        uv[3].swap(0, 1);
        assert_eq!(flipped(&uv), 1);
    }

    #[test]
    fn whatever_is_missing_or_broken_still_gives_a_picture() {
        sheet(&mesh(None), &small(), &Serial);
        let none = PictureMesh { positions: &[], triangles: &[], corner_uv: Some(&[]), chart: None, exposure: None };
        sheet(&none, &small(), &Serial);
        let mut uv = uv();
        uv[1][2].x = f64::NAN;
        uv[3][0] = DVec2::splat(1e200);
        let mut positions = POSITIONS;
        positions[4].y = f64::INFINITY;
        let broken = PictureMesh {
            positions: &positions,
            triangles: &[[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [9, 9, 9], [1, 1, 1]],
            corner_uv: Some(&uv),
            chart: Some(&[7]),
            exposure: Some(&[0.5]),
        };
        sheet(&broken, &SheetOptions { z_up: true, ..small() }, &Serial);
    }
}
