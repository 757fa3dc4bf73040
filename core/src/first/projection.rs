//! Charts without a search: faces that look the same way of six, laid down by looking at them from there.
//!
//! Each polygon goes to the axis that the normals around it are nearest to, if it faces that way; few among others join them.
//! Such a chart has no face turned over, each is stretched by the cosine of its tilt (symmetric Dirichlet energy over 4 at the most 4/3
//! where no polygon has joined another direction), and two layers of one that lie on each other are the caller's to part.
//! Guarantee: disks; no flip but of bent polygons. Cost: O(n log n).

use super::disks::disks_again;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::union_find::UnionFind;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};
use glam::{DVec2, DVec3};

/// Times that normals are joined by those beside them: a scan is rough.
const SMOOTHINGS: usize = 8;
/// Times that polygons look at their neighbours' ways.
const SWEEPS: usize = 8;
/// Cosine to an axis down to which a polygon may go with its neighbours.
const TILTED: f64 = 0.08;

/// Writes charts of the whole surface: flags of half-edges, and points at corners.
pub fn project(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let way = scratch.take::<u8>(faces)?;
    ways(way, surface, scratch.frame())?;
    cut.fill(0);
    for c in 0..cut.len() as u32 {
        let t = surface.twin[c as usize];
        if t != NONE && way[(c / 3) as usize] != way[(t / 3) as usize] {
            surface.set_cut(cut, c, true);
        }
    }
    for (c, uv) in uv.iter_mut().enumerate() {
        *uv = seen_from(way[c / 3], surface.mesh.position(c as u32));
    }
    disks_again(cut, surface, scratch.frame())?;
    keep_area(uv, cut, surface, scratch)
}

/// A point as seen along an axis: 0, 1, 2 from the positive ends of x, y, z, then from the negative ones.
fn seen_from(way: u8, p: DVec3) -> DVec2 {
    let p = p.to_array();
    let axis = usize::from(way) % 3;
    let (u, v) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
    if way < 3 { DVec2::new(u, v) } else { DVec2::new(v, u) }
}

/// How far a vector points each way.
fn along(n: DVec3) -> [f64; 6] {
    [n.x, n.y, n.z, -n.x, -n.y, -n.z]
}

/// The way that each face is seen from; triangles of a polygon share theirs.
fn ways(way: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let mesh = surface.mesh;
    let faces = mesh.faces.len();
    let mut sets = UnionFind::new(scratch.take::<u32>(faces)?);
    for c in 0..3 * faces as u32 {
        let t = surface.twin[c as usize];
        if t != NONE && surface.cost[c as usize].is_infinite() {
            sets.union(c / 3, t / 3);
        }
    }
    let polygon = scratch.take::<u32>(faces)?;
    polygon.iter_mut().enumerate().for_each(|(f, p)| *p = sets.find(f as u32));
    let sum = scratch.take::<DVec3>(faces)?;
    let tilt = scratch.take_filled::<[f64; 6]>(faces, [1.0; 6])?; // least cosine of a polygon's triangles
    for (f, p) in polygon.iter().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.position((3 * f + i) as u32));
        let n = (b - a).cross(c - a);
        sum[*p as usize] += n;
        let unit = along(n.normalize_or_zero());
        let least = &mut tilt[*p as usize];
        least.iter_mut().zip(unit).for_each(|(l, x)| *l = l.min(x));
    }
    let own = scratch.take::<u8>(faces)?; // of each polygon
    own.iter_mut().zip(sum.iter()).for_each(|(o, n)| *o = largest(along(*n)));
    let smooth = scratch.take::<DVec3>(faces)?;
    for _ in 0..SMOOTHINGS {
        smooth.copy_from(sum);
        beside(surface, polygon, |_, p, other| smooth[p] += sum[other]);
        sum.copy_from(smooth);
        sum.iter_mut().for_each(|n| *n *= 0.25);
    }
    for (p, own) in own.iter_mut().enumerate() {
        let wanted = largest(along(sum[p]));
        if tilt[p][usize::from(wanted)] > TILTED {
            *own = wanted;
        }
    }
    let votes = scratch.take::<[f64; 6]>(faces)?;
    for _ in 0..SWEEPS {
        votes.fill([0.0; 6]);
        beside(surface, polygon, |c, p, other| {
            votes[p][usize::from(own[other])] += mesh.position(c).distance(mesh.position(next(c)));
        });
        for (p, votes) in votes.iter().enumerate() {
            let most = largest(*votes);
            if votes[usize::from(most)] > 0.5 * votes.iter().sum::<f64>() && tilt[p][usize::from(most)] > TILTED {
                own[p] = most;
            }
        }
    }
    way.iter_mut().zip(polygon.iter()).for_each(|(w, p)| *w = own[*p as usize]);
    Ok(())
}

/// Visits the half-edges between two polygons, with the number of each.
fn beside(surface: &Surface, polygon: &[u32], mut visit: impl FnMut(u32, usize, usize)) {
    for c in 0..surface.twin.len() as u32 {
        let t = surface.twin[c as usize];
        if t != NONE {
            let [p, other] = [c, t].map(|c| polygon[(c / 3) as usize] as usize);
            if p != other {
                visit(c, p, other);
            }
        }
    }
}

/// The first of the largest.
fn largest(values: [f64; 6]) -> u8 {
    let mut best = 0;
    for (i, x) in values.iter().enumerate() {
        if *x > values[usize::from(best)] {
            best = i as u8;
        }
    }
    best
}

/// Scales each chart to its area in space.
fn keep_area(uv: &mut [DVec2], cut: &[u8], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let charts = ChartList::new(surface, cut, &mut scratch)?;
    for k in 0..charts.count() {
        let faces = charts.faces_of(k);
        let (mut flat, mut solid) = (0.0, 0.0);
        for f in faces.iter().map(|f| *f as usize) {
            flat += 0.5 * (uv[3 * f + 1] - uv[3 * f]).perp_dot(uv[3 * f + 2] - uv[3 * f]);
            solid += surface.rest[f].area;
        }
        let scale = sqrt(solid / flat);
        if scale.is_finite() && scale > 0.0 {
            faces.iter().flat_map(|f| 3 * f..3 * f + 3).for_each(|c| uv[c as usize] *= scale);
        }
    }
    Ok(())
}
