//! The atlas that is carried over: a working mesh whose cuts are the borders of its UVs, and its charts.
//!
//! A chart that lies mirrored in the square is seen from behind (u becomes 1 - u), so that all that follows may take faces to be
//! counter-clockwise; [`SourceAtlas::seen`] is that and its own inverse.

use super::closest::{Closest, ClosestTree, closest_tree_need, on_triangle};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::charts::surface::{Surface, surface_need};
use crate::mesh::view::{NONE, next};
use crate::mesh::working::{FORCED, Working};
use glam::{DVec2, DVec3};

/// Longest stretch of a face's map that is carried beyond its border, over the chart's mean.
const STEEPEST: f64 = 1.5;

/// The mesh whose atlas it is.
pub struct SourceAtlas<'a> {
    /// The mesh with the corners at its vertices.
    pub surface: Surface<'a>,
    /// The borders of the UVs, on both sides.
    pub cut: &'a [u8], // (3 f)
    /// UVs, as seen.
    pub uv: &'a [DVec2], // (3 f)
    /// Chart of each face.
    pub chart: &'a [u32], // (f)
    /// How many there are.
    pub charts: usize,
    /// Whether each chart is mirrored.
    pub mirrored: &'a [u8], // (charts)
    /// Root of UV area over area, of each chart.
    pub scale: &'a [f64], // (charts)
    /// Finds closest points.
    pub tree: ClosestTree<'a>,
    /// Whether the wedge of each corner is on the border of its chart.
    on_border: &'a [u8], // (3 f)
    /// Faces that are turned over against the rest of their chart.
    pub flipped: usize,
}

/// A place on the atlas.
#[derive(Clone, Copy, Debug, Default)]
pub struct Target {
    /// UV of the closest point of the chart, as seen.
    pub inner: DVec2,
    /// The same carried on to the place itself where that lies beyond the chart's border.
    pub outer: DVec2,
    /// Squared distance.
    pub squared: f64,
}

/// Bytes that [`SourceAtlas::new`] takes.
pub const fn source_need(vertices: usize, faces: usize) -> usize {
    surface_need(faces, vertices)
        .saturating_add(closest_tree_need(faces))
        .saturating_add(bytes_for::<DVec2>(3 * faces))
        .saturating_add(bytes_for::<u8>(3 * faces).saturating_mul(2))
        .saturating_add(bytes_for::<u32>(faces).saturating_mul(2))
        .saturating_add(bytes_for::<[f64; 2]>(faces).saturating_mul(2))
}

impl<'a> SourceAtlas<'a> {
    /// `uv_of` answers the UV of an input corner.
    pub fn new(
        working: &Working<'a>,
        uv_of: impl Fn(u32) -> DVec2,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let (mesh, corners) = (working.mesh(), working.twin.len());
        let surface = Surface::new(mesh, working.twin, &[], &[], keep)?;
        let cut = keep.take::<u8>(corners)?;
        cut.iter_mut().zip(working.fixed).for_each(|(c, mark)| *c = u8::from(*mark == FORCED));
        let uv = keep.take::<DVec2>(corners)?;
        uv.iter_mut().zip(working.corner_source).for_each(|(uv, c)| *uv = uv_of(*c));
        let chart = keep.take::<u32>(mesh.faces.len())?;
        let charts = surface.charts(cut, chart, keep.frame().take(mesh.faces.len())?);
        let mirrored = keep.take::<u8>(charts)?;
        let scale = keep.take::<f64>(charts)?;
        {
            let mut frame = keep.frame();
            let (area, flat) = (frame.take::<f64>(charts)?, frame.take::<f64>(charts)?);
            for (f, k) in chart.iter().enumerate() {
                let normal = mesh.area_vector(f);
                area[*k as usize] += sqrt(normal.dot(normal));
                flat[*k as usize] += doubled(uv, f);
            }
            for k in 0..charts {
                mirrored[k] = u8::from(flat[k] < 0.0);
                scale[k] = sqrt(flat[k].abs() / area[k].max(f64::MIN_POSITIVE));
            }
        }
        for (_, uv) in uv.iter_mut().enumerate().filter(|(c, _)| mirrored[chart[c / 3] as usize] != 0) {
            uv.x = 1.0 - uv.x;
        }
        let flipped = (0..mesh.faces.len()).filter(|f| doubled(uv, *f) < 0.0).count();
        let on_border = keep.take::<u8>(corners)?;
        for c in (0..corners as u32).filter(|c| surface.is_open(cut, *c)) {
            for end in [c, next(c)] {
                for d in surface.wedge(cut, surface.wedge_start(cut, end)) {
                    on_border[d as usize] = 1;
                }
            }
        }
        let tree = ClosestTree::new(mesh, keep)?;
        Ok(Self { surface, cut, uv, chart, charts, mirrored, scale, tree, on_border, flipped })
    }

    /// A UV of `chart` as it is seen; of one that is seen, as it is.
    pub fn seen(&self, chart: u32, uv: DVec2) -> DVec2 {
        if self.mirrored[chart as usize] != 0 { DVec2::new(1.0 - uv.x, uv.y) } else { uv }
    }

    /// Whether the atlas lies in the unit square.
    pub fn is_in_square(&self) -> bool {
        self.uv.iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0)
    }

    /// Corners of a face in space.
    pub fn triangle(&self, face: u32) -> [DVec3; 3] {
        self.surface.mesh.faces[face as usize].map(|v| self.surface.mesh.positions[v as usize])
    }

    /// The place on the atlas of `p`, whose closest point is `at`.
    pub fn target(&self, p: DVec3, at: &Closest) -> Target {
        let f = at.face as usize;
        let uv = [0, 1, 2].map(|i| self.uv[3 * f + i]);
        let inner = uv[0] * at.weights[0] + uv[1] * at.weights[1] + uv[2] * at.weights[2];
        let mut target = Target { inner, outer: inner, squared: at.squared };
        if !self.is_at_border(at) {
            return target;
        }
        let [a, b, c] = self.triangle(at.face);
        let way = p - (a * at.weights[0] + b * at.weights[1] + c * at.weights[2]);
        // The map's derivative along `way`: coordinates in the frame of two sides.
        let (x, y) = (b - a, c - a);
        let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
        let (wx, wy) = (way.dot(x), way.dot(y));
        let det = xx * yy - xy * xy;
        if det > 1e-9 * xx * yy {
            let step = (uv[1] - uv[0]) * ((yy * wx - xy * wy) / det) + (uv[2] - uv[0]) * ((xx * wy - xy * wx) / det);
            let most = STEEPEST * self.scale[self.chart[f] as usize] * sqrt(way.dot(way));
            let length = sqrt(step.dot(step));
            target.outer = inner + if length > most { step * (most / length) } else { step };
        }
        target
    }

    /// Whether a point is on the border of its chart.
    fn is_at_border(&self, at: &Closest) -> bool {
        let c = 3 * at.face;
        let zero = at.weights.map(|w| w <= 1e-12);
        match zero {
            [true, false, false] => self.surface.is_open(self.cut, c + 1),
            [false, true, false] => self.surface.is_open(self.cut, c + 2),
            [false, false, true] => self.surface.is_open(self.cut, c),
            [false, false, false] => false,
            _ => (0..3).any(|i| !zero[i as usize] && self.on_border[(c + i) as usize] != 0),
        }
    }

    /// The closest point to `p` that can be reached from `face` without crossing a border, over faces that are no farther from
    /// `p` than that one.
    pub fn walk(&self, face: u32, p: DVec3, walk: &mut Walking) -> Closest {
        let (weights, squared) = on_triangle(p, self.triangle(face));
        let mut best = Closest { face, weights, squared };
        let limit = squared;
        walk.stamp = walk.stamp.wrapping_add(1);
        walk.seen[face as usize] = walk.stamp;
        walk.queue[0] = face;
        let (mut head, mut tail) = (0, 1);
        while head < tail {
            let f = walk.queue[head];
            head += 1;
            for t in (3 * f..3 * f + 3).filter_map(|c| self.surface.across(self.cut, c)) {
                let face = t / 3;
                if walk.seen[face as usize] == walk.stamp {
                    continue;
                }
                walk.seen[face as usize] = walk.stamp;
                let (weights, squared) = on_triangle(p, self.triangle(face));
                if squared > limit {
                    continue;
                }
                if squared < best.squared {
                    best = Closest { face, weights, squared };
                }
                walk.queue[tail] = face;
                tail += 1;
            }
        }
        best
    }
}

/// Twice the signed area of a face in UV.
fn doubled(uv: &[DVec2], f: usize) -> f64 {
    (uv[3 * f + 1] - uv[3 * f]).perp_dot(uv[3 * f + 2] - uv[3 * f])
}

/// Memory of [`SourceAtlas::walk`].
pub struct Walking<'a> {
    seen: &'a mut [u32],  // (f)
    queue: &'a mut [u32], // (f)
    stamp: u32,
}

impl<'a> Walking<'a> {
    /// For a mesh of `faces`.
    pub fn new(faces: usize, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self { seen: keep.take_filled(faces, NONE)?, queue: keep.take(faces)?, stamp: 0 })
    }
}
