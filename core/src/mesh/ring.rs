//! The faces around one vertex, copied out so that moves of the vertex onto its neighbours can be tried quickly.

use super::collapse::{Collapse, CornerTable, fan};
use super::view::{NONE, next, prev};
use glam::DVec3;
use heapless::Vec;

/// Vertices of more faces have no ring here: trying all their moves is quadratic.
pub const MOST: usize = 64;
/// A face may turn by this cosine at the most (78 degrees) in one move.
const TURN: f64 = 0.2;
/// No move may make a face of lower quality (1: equilateral), but where there was a worse one before.
const SLIVER: f64 = 0.1;

/// Face i is (centre, neighbour i, neighbour i + 1), counter-clockwise; an open fan has one neighbour more than faces.
#[derive(Default)]
pub struct Ring {
    /// Each neighbour.
    pub vertex: Vec<u32, { MOST + 1 }>,
    /// Where it is.
    pub point: Vec<DVec3, { MOST + 1 }>,
    /// Area of all faces.
    pub area: f64,
    corner: Vec<u32, MOST>,   // of each face, at the centre
    normal: Vec<DVec3, MOST>, // of each face, as long as twice its area
    worst: f64,               // least squared quality
}

impl Ring {
    /// Reads the ring around the vertex of `start`, on the border the corner whose half-edge is the border; `None` where
    /// it has too many faces.
    pub fn read(&mut self, positions: &[DVec3], table: &CornerTable, start: u32) -> Option<()> {
        let ring = self;
        ring.vertex.clear();
        ring.point.clear();
        ring.corner.clear();
        ring.normal.clear();
        (ring.area, ring.worst) = (0.0, 1.0);
        let mut add = |v: u32| {
            ring.vertex.push(v).ok()?;
            ring.point.push(positions[v as usize]).ok()
        };
        for c in fan(table.twin, start) {
            ring.corner.push(c).ok()?;
            add(table.vertex(next(c)))?;
            if table.twin[prev(c) as usize] == NONE {
                add(table.vertex(prev(c)))?;
            }
        }
        let centre = positions[table.vertex(start) as usize];
        for i in 0..ring.corner.len() {
            let (b, c) = (ring.point[i], ring.point[ring.following(i)]);
            let normal = (b - centre).cross(c - centre);
            ring.area += 0.5 * crate::base::real::sqrt(normal.dot(normal));
            ring.worst = ring.worst.min(squared_quality(centre, b, c, normal));
            ring.normal.push(normal).ok()?;
        }
        Some(())
    }

    fn following(&self, i: usize) -> usize {
        if i + 1 == self.vertex.len() { 0 } else { i + 1 }
    }

    fn is_open(&self) -> bool {
        self.vertex.len() > self.corner.len()
    }

    /// The collapse of the centre onto neighbour `i`: from the border only along it.
    pub fn collapse(&self, i: usize) -> Option<Collapse> {
        let last = self.vertex.len() - 1;
        if !self.is_open() || i == 0 {
            Some(Collapse::new(self.corner[i], false))
        } else if i == last {
            Some(Collapse::new(prev(self.corner[i - 1]), true))
        } else {
            None
        }
    }

    /// Whether the collapse onto neighbour `i` leaves one face twice, as on a tetrahedron. (Where more than three faces
    /// meet, the link condition already forbids it.)
    pub fn doubles(&self, table: &CornerTable, i: usize) -> bool {
        !self.is_open()
            && self.corner.len() == 3
            && self.corner.iter().any(|c| {
                let t = table.twin[next(*c) as usize];
                t != NONE && table.vertex(prev(t)) == self.vertex[i]
            })
    }

    /// Worst quality of the faces that stay, once the centre stands at neighbour `i`; `None` where one turns over or
    /// becomes a sliver.
    pub fn quality_at(&self, i: usize) -> Option<f64> {
        let to = self.point[i];
        let mut least = 1.0f64;
        for (f, before) in self.normal.iter().enumerate() {
            let g = self.following(f);
            if f == i || g == i {
                continue;
            }
            let (b, c) = (self.point[f], self.point[g]);
            let after = (b - to).cross(c - to);
            let cosine = before.dot(after);
            if cosine < 0.0 || cosine * cosine < TURN * TURN * before.dot(*before) * after.dot(after) {
                return None;
            }
            least = least.min(squared_quality(to, b, c, after));
        }
        let stays = least > 0.0 && (least >= SLIVER * SLIVER || least > self.worst);
        stays.then(|| crate::base::real::sqrt(least))
    }
}

/// (4 sqrt(3) area / sum of squared edges)^2: 1 for an equilateral triangle, 0 for a flat one. `normal` is
/// (b - a) x (c - a).
fn squared_quality(a: DVec3, b: DVec3, c: DVec3, normal: DVec3) -> f64 {
    let squares = (b - a).dot(b - a) + (c - b).dot(c - b) + (a - c).dot(a - c);
    let quality = 12.0 * normal.dot(normal) / (squares * squares);
    if quality.is_nan() { 0.0 } else { quality.min(1.0) }
}
