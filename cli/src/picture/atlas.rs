//! The atlas: charts filled in UV space, their borders as lines, overlaps and flips made to stand out. Of charts that coincide the first
//! is drawn: they are no overlap.

use super::surface::PictureSurface;
use crate::base::colour::{self, INK, PANEL, Rgb, SEAM, linear, srgb};
use glam::{DVec2, DVec3, Vec3};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::{Workers, for_each_chunk};
use seamwright_core::judge::facing::{find_turned, find_turned_need};
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::stacks::{find_stacked, find_stacked_need};
use seamwright_core::judge::wedges::{uv_topology, uv_topology_need};
use seamwright_core::mesh::view::NONE;
use seamwright_core::plane::grid::GRID_BITS;

/// Samples a pixel and axis.
const SAMPLES: usize = 2;
/// Rows of pixels a task.
const STRIP: usize = 16;
/// Faces turned against their chart.
const FLIPPED: Rgb = [222, 40, 190];

/// The picture and what was counted on the way.
pub struct DrawnAtlas {
    pub pixels: Vec<Rgb>, // (size, size)
    /// Share of the unit square's samples that a chart covers.
    pub utilisation: f64,
    /// Share of covered samples that two faces cover.
    pub overlap: f64,
    /// Charts that coincide with another.
    pub stacked: usize,
    /// Faces turned against their chart's greater part.
    pub flipped: usize,
}

#[derive(Clone, Copy)]
struct AtlasSample {
    face: u32,
    depth: u32,
}

/// Draws the unit square, or the UVs' own box where they leave it, `size` pixels a side.
pub fn draw(surface: &PictureSurface, size: usize, workers: &dyn Workers) -> DrawnAtlas {
    let uv = surface.uv.as_deref().unwrap_or(&[]);
    let (corner, side) = frame(uv);
    let n = size * SAMPLES;
    let Judged { turned, hidden, stacked } = judged(surface, uv);
    let is_flipped = flips(surface, uv, &turned, &hidden);
    let mut samples = vec![AtlasSample { face: NONE, depth: 0 }; n * n];
    let place = |t: DVec2| (t - corner) / side * n as f64 - 0.5; // sample centres at integers, v up
    for_each_chunk(workers, &mut samples, n * STRIP, &|strip, samples| {
        let first = strip * STRIP;
        let rows = samples.len() / n;
        for (f, corners) in uv.iter().enumerate().filter(|(f, c)| c[0].is_finite() && hidden[*f] == 0) {
            let t = corners.map(place);
            let low = t[0].min(t[1]).min(t[2]).ceil().max(DVec2::new(0.0, first as f64));
            let high = t[0].max(t[1]).max(t[2]).floor().min(DVec2::new(n as f64, (first + rows) as f64) - 1.0);
            if low.x > high.x || low.y > high.y {
                continue;
            }
            for y in low.y as usize..=high.y as usize {
                for x in low.x as usize..=high.x as usize {
                    if covers(t, DVec2::new(x as f64, y as f64)) {
                        let sample = &mut samples[(y - first) * n + x];
                        sample.depth += 1;
                        sample.face = f as u32;
                    }
                }
            }
        }
    });
    let line = lines(surface, n, place);
    let inside = |i: usize| {
        let t = corner + DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) / n as f64 * side;
        (t.cmpge(DVec2::ZERO) & t.cmple(DVec2::ONE)).all()
    };
    let covered = samples.iter().filter(|s| s.depth > 0).count();
    let twice = samples.iter().filter(|s| s.depth > 1).count();
    let square = (0..n * n).filter(|i| inside(*i)).count();
    let used = (0..n * n).filter(|i| inside(*i) && samples[*i].depth > 0).count();
    let light = |i: usize| -> Vec3 {
        let base = match samples[i] {
            AtlasSample { depth: 0, .. } => linear(PANEL) * if inside(i) { 1.0 } else { 0.75 },
            AtlasSample { depth: 1, face } if is_flipped[face as usize] => linear(FLIPPED),
            AtlasSample { depth: 1, face } => match surface.chart[face as usize] {
                NONE => linear(INK),
                chart => colour::chart(chart),
            },
            _ => linear(SEAM),
        };
        if line[i] { linear(INK) * 0.5 + base * 0.2 } else { base }
    };
    let mut pixels = vec![[0; 3]; size * size];
    for_each_chunk(workers, &mut pixels, size, &|row, out| {
        for (column, out) in out.iter_mut().enumerate() {
            let mut sum = Vec3::ZERO;
            for s in 0..SAMPLES * SAMPLES {
                let (x, y) = (column * SAMPLES + s % SAMPLES, (size - 1 - row) * SAMPLES + s / SAMPLES);
                sum += light(y * n + x);
            }
            *out = srgb(sum / (SAMPLES * SAMPLES) as f32);
        }
    });
    DrawnAtlas {
        pixels,
        utilisation: used as f64 / square.max(1) as f64,
        overlap: twice as f64 / covered.max(1) as f64,
        stacked,
        flipped: is_flipped.iter().filter(|f| **f).count(),
    }
}

/// Lower corner and side of what is shown: the unit square, widened where UVs leave it.
fn frame(uv: &[[DVec2; 3]]) -> (DVec2, f64) {
    let mut low = DVec2::ZERO;
    let mut high = DVec2::ONE;
    for t in uv.iter().flatten().filter(|t| t.is_finite()) {
        (low, high) = (low.min(*t), high.max(*t));
    }
    if low == DVec2::ZERO && high == DVec2::ONE {
        return (low, 1.0);
    }
    let side = (high - low).max_element();
    (low - 0.02 * side, side * 1.04)
}

/// Whether each face's signed UV area is against the greater part of its chart, after those that neighbours outvote are turned,
/// as `measure` does; of what is not hidden.
fn flips(surface: &PictureSurface, uv: &[[DVec2; 3]], turned: &[u8], hidden: &[u8]) -> Vec<bool> {
    let area = |f: usize| (uv[f][1] - uv[f][0]).perp_dot(uv[f][2] - uv[f][0]) * if turned[f] != 0 { -1.0 } else { 1.0 };
    let counts = |f: usize| surface.chart[f] != NONE && hidden[f] == 0;
    let mut total = vec![0.0; surface.chart_count];
    (0..uv.len()).filter(|f| counts(*f)).for_each(|f| total[surface.chart[f] as usize] += area(f));
    (0..uv.len()).map(|f| counts(f) && area(f) * total[surface.chart[f] as usize] < 0.0).collect()
}

/// What core's judge knows of faces.
struct Judged {
    /// 1 for each that neighbours outvote.
    turned: Vec<u8>,
    /// 1 for each of a chart that coincides with one before it.
    hidden: Vec<u8>,
    /// Such charts.
    stacked: usize,
}

fn judged(surface: &PictureSurface, uv: &[[DVec2; 3]]) -> Judged {
    let positions: Vec<DVec3> = surface.points.iter().map(|p| p.as_dvec3()).collect();
    let mesh = UvMesh { positions: &positions, triangles: &surface.faces[..uv.len()], corner_uv: uv };
    let need = find_turned_need(uv.len()).max(find_stacked_need(uv.len()));
    let mut bytes = vec![0; uv_topology_need(positions.len(), uv.len()) + need];
    let mut scratch = Scratch::new(&mut bytes);
    let solid: Vec<f64> = (0..uv.len()).map(|f| 0.5 * mesh.normal(f).length()).collect();
    let mut judged = Judged { turned: vec![0; uv.len()], hidden: vec![0; uv.len()], stacked: 0 };
    let found = uv_topology(mesh, &mut scratch).and_then(|topology| {
        find_turned(&mut judged.turned, mesh, &topology, &solid, scratch.frame())?;
        let bits = mesh.uv_box().map_or(GRID_BITS, |b| b.grid_bits());
        let (chart, count) = (topology.chart, topology.chart_count);
        judged.stacked = find_stacked(&mut judged.hidden, uv, chart, count, bits, scratch)?.charts;
        Ok(())
    });
    debug_assert!(found.is_ok(), "the memory is what they ask for");
    judged
}

/// Half-open cover: a sample on an edge belongs to one of the edge's two faces, because both compute the edge from the
/// same end.
fn covers(t: [DVec2; 3], p: DVec2) -> bool {
    let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
    let inside = |a: DVec2, b: DVec2| {
        let (a, b) = if area > 0.0 { (a, b) } else { (b, a) };
        let swap = (a.x, a.y) > (b.x, b.y);
        let (c, d) = if swap { (b, a) } else { (a, b) };
        let e = (d - c).perp_dot(p - c) * if swap { -1.0 } else { 1.0 };
        e > 0.0 || (e == 0.0 && swap)
    };
    area != 0.0 && inside(t[0], t[1]) && inside(t[1], t[2]) && inside(t[2], t[0])
}

/// Samples within 0.7 pixels of a chart's border.
fn lines(surface: &PictureSurface, n: usize, place: impl Fn(DVec2) -> DVec2) -> Vec<bool> {
    let radius = 0.7 * SAMPLES as f64;
    let mut line = vec![false; n * n];
    for ends in surface.outline.iter().filter(|e| e[0].is_finite() && e[1].is_finite()) {
        let [a, b] = ends.map(&place);
        let low = (a.min(b) - radius).ceil().max(DVec2::ZERO);
        let high = (a.max(b) + radius).floor().min(DVec2::splat(n as f64 - 1.0));
        let along = b - a;
        let mut y = low.y;
        while y <= high.y {
            let mut x = low.x;
            while x <= high.x {
                let p = DVec2::new(x, y);
                let t = ((p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                if (a + along * t).distance_squared(p) <= radius * radius {
                    line[y as usize * n + x as usize] = true;
                }
                x += 1.0;
            }
            y += 1.0;
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_on_a_shared_edge_is_covered_once() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(DVec2::from);
        for i in 1..4 {
            let p = DVec2::splat(i as f64);
            let halves = [[square[0], square[1], square[2]], [square[0], square[2], square[3]]];
            assert_eq!(halves.iter().filter(|t| covers(**t, p)).count(), 1);
            assert_eq!(halves.iter().filter(|t| covers([t[2], t[1], t[0]], p)).count(), 1);
        }
    }
}
