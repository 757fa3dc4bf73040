//! How much the surface turns at each edge, seen against what it does around.
//!
//! Sixty atlases that artists made say where people cut: where the surface turns, hardly where it is hidden. As a guess at
//! their seams the turn between two faces has .82 of the area under the curve, and .83 once half of what the other edges of
//! the two faces turn is taken off: an edge between the facets of a coarse sphere is no crease. A bevel is a crease in
//! several rows: the turns of narrow rows are added up, since each of them is as good a place as the one sharp edge would be.
//! What a small face says of its own direction is only as good as its corners are: the file's tolerance is taken off.
//! Cost: O(f).

use crate::base::real::{atan2, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::{MeshView, NONE, next, prev};
use glam::DVec3;

/// Share of the mean turn of the other edges of both faces that is taken off. On artists' seams .25 and 1 are as good as
/// .5 to .002 of the area under the curve; none is .01 less.
const AROUND: f64 = 0.5;
/// Rows of a bevel on either side at the most.
const ROWS: usize = 8;
/// Least turn of an edge that is a row of a bevel, in degrees.
const LEAST: f64 = 3.0;
/// Farthest that a row of the same bevel is, over the length of the edge. Twice as much takes the low-polygon limbs of
/// characters for bevels.
const NARROW: f64 = 0.15;
/// And over the square root of all area.
const WIDTH: f64 = 0.01;
/// Least cosine between an edge and another row.
const PARALLEL: f64 = 0.95;

/// Scratch bytes for [`turns`].
pub const fn turns_need(faces: usize) -> usize {
    bytes_for::<f64>(3 * faces) + 2 * bytes_for::<f64>(faces)
}

/// Angle between the two faces at each half-edge in degrees, 0 to 180, 0 on the border.
pub fn plain_turns(turn: &mut [f64], mesh: MeshView, twin: &[u32]) {
    for c in 0..mesh.corner_count() as u32 {
        let t = twin[c as usize];
        if t == NONE {
            turn[c as usize] = 0.0;
        } else if c < t {
            let (p, q) = (mesh.area_vector(c as usize / 3), mesh.area_vector(t as usize / 3));
            let angle = degrees(p.cross(q), p.dot(q));
            turn[c as usize] = angle;
            turn[t as usize] = angle;
        }
    }
}

/// Turn of each half-edge (one entry a corner, equal for twins) against its surroundings, in degrees, 0 to 180. `plain` are
/// the angles as they are ([`plain_turns`]); `tolerance` says how far corners may be from what they stand for.
pub fn turns(
    turn: &mut [f64],
    plain: &[f64],
    mesh: MeshView,
    twin: &[u32],
    tolerance: f64,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = mesh.faces.len();
    scratch.require(turns_need(faces))?;
    let length = scratch.take::<f64>(3 * faces)?;
    let around = scratch.take::<f64>(faces)?; // turn times length over the edges of a face
    let girth = scratch.take::<f64>(faces)?;
    let mut area = 0.0;
    for c in 0..3 * faces as u32 {
        let d = edge(mesh, c);
        let l = sqrt(d.dot(d));
        length[c as usize] = l;
        around[c as usize / 3] += plain[c as usize] * l;
        girth[c as usize / 3] += l;
    }
    for f in 0..faces {
        let n = mesh.area_vector(f);
        area += 0.5 * sqrt(n.dot(n));
    }
    let surface = Rows { mesh, twin, plain, length, width: WIDTH * sqrt(area) };
    for c in 0..3 * faces as u32 {
        let t = twin[c as usize];
        if t == NONE {
            turn[c as usize] = 0.0;
        } else if c < t {
            let (f, g, l) = (c as usize / 3, t as usize / 3, length[c as usize]);
            let own = plain[c as usize];
            let rest = (around[f] + around[g] - 2.0 * own * l) / (girth[f] + girth[g] - 2.0 * l).max(f64::MIN_POSITIVE);
            let unsure = if tolerance > 0.0 { surface.doubt(c, tolerance) + surface.doubt(t, tolerance) } else { 0.0 };
            let seen = (surface.bevel(c, t) - AROUND * rest - unsure).clamp(0.0, 180.0);
            turn[c as usize] = seen;
            turn[t as usize] = seen;
        }
    }
    Ok(())
}

/// What the rows of a bevel are found with.
struct Rows<'a> {
    mesh: MeshView<'a>,
    twin: &'a [u32],
    plain: &'a [f64],
    length: &'a [f64],
    width: f64,
}

impl Rows<'_> {
    /// Turn at the edge of `c` and its twin `t`, with the rows beside it that turn the same way.
    fn bevel(&self, c: u32, t: u32) -> f64 {
        let own = self.plain[c as usize];
        if own < LEAST {
            return own;
        }
        (own + self.beside(c) + self.beside(t)).min(180.0)
    }

    /// Sum of the turns of the rows on the side of the face of `start`.
    fn beside(&self, start: u32) -> f64 {
        let along = edge(self.mesh, start) / self.length[start as usize].max(f64::MIN_POSITIVE);
        let middle = self.middle(start);
        let reach = self.width.min(NARROW * self.length[start as usize]);
        let (mut at, mut sum) = (start, 0.0);
        for _ in 0..2 * ROWS {
            let Some(across) = self.across(at, along) else { break };
            let aside = self.middle(across) - middle;
            let aside = aside - along * aside.dot(along);
            if aside.dot(aside) > reach * reach {
                break;
            }
            let turn = self.plain[across as usize];
            if turn >= LEAST {
                if self.is_convex(across) != self.is_convex(start) {
                    break;
                }
                sum += turn;
            }
            at = self.twin[across as usize];
        }
        sum
    }

    /// The other half-edge of the face of `c` that runs along the direction `along`, if one does and has a face beyond.
    fn across(&self, c: u32, along: DVec3) -> Option<u32> {
        let cosine = |e: u32| {
            let l = self.length[e as usize];
            if l > 0.0 { edge(self.mesh, e).dot(along).abs() / l } else { 0.0 }
        };
        let (a, b) = (next(c), prev(c));
        let best = if cosine(a) >= cosine(b) { a } else { b };
        (cosine(best) >= PARALLEL && self.twin[best as usize] != NONE).then_some(best)
    }

    /// Whether the faces on both sides of the edge of `c` fall away from each other's outside.
    fn is_convex(&self, c: u32) -> bool {
        let t = self.twin[c as usize];
        let d = self.mesh.position(prev(t)) - self.mesh.position(c);
        d.dot(self.mesh.area_vector(c as usize / 3)) < 0.0
    }

    fn middle(&self, c: u32) -> DVec3 {
        (self.mesh.position(c) + self.mesh.position(next(c))) * 0.5
    }

    /// How far the direction of the face of `c` may be turned about that edge by corners that are off by `tolerance`, in
    /// degrees.
    fn doubt(&self, c: u32, tolerance: f64) -> f64 {
        let n = self.mesh.area_vector(c as usize / 3);
        let height = sqrt(n.dot(n)) / self.length[c as usize].max(f64::MIN_POSITIVE);
        atan2(2.0 * tolerance, height).to_degrees()
    }
}

/// The half-edge of `c` as a vector.
fn edge(mesh: MeshView, c: u32) -> DVec3 {
    mesh.position(next(c)) - mesh.position(c)
}

/// Angle whose sine is the length of `cross` and whose cosine is `dot`, up to a common factor.
fn degrees(cross: DVec3, dot: f64) -> f64 {
    atan2(sqrt(cross.dot(cross)), dot).to_degrees()
}
