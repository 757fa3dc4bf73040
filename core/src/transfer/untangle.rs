//! Faces that a map turns over, turned back by moving as few nodes as will do.
//!
//! Around each such face a patch of nodes is free. Every face of the patch says where its corners should be: its map onto the plane
//! with singular values brought into bounds (the nearest such map; a face that is turned over has its lesser one negative), and nodes
//! move to the mean of what their faces say and, a little, to where they belong. A patch in which faces stay turned over grows by a ring
//! (local and global steps as in Bouaziz et al., *Shape-Up*, 2012). What is not near a turned face does not move.
//! Limit: a patch whose border is tangled with itself has no answer; the caller counts.

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::solve::energy::Rest;
use glam::DVec2;

/// Rounds, each with one ring more.
const ROUNDS: usize = 14;
/// Sweeps a round.
const SWEEPS: usize = 120;
/// Sweeps between two looks.
const LOOK: usize = 10;
/// Singular values are brought between these, over the chart's scale.
const LEAST: f64 = 0.25;
const MOST: f64 = 3.0;
/// Determinant, over the chart's scale squared, from which a face is not turned over.
const TURNED: f64 = 1e-4;
/// Weight of where a node belongs over that of one face.
const PULL: f64 = 0.05;

/// The faces as the map should have them.
#[derive(Clone, Copy)]
pub struct Shapes<'s> {
    /// Nodes of each face.
    pub node: &'s [[u32; 3]], // (f)
    /// Rest shape of each face.
    pub rest: &'s [Rest], // (f)
    /// UV length over length, of each face's chart.
    pub scale: &'s dyn Fn(usize) -> f64,
}

impl Shapes<'_> {
    /// Whether a face is turned over, or next to flat though it should not be.
    fn is_bad(&self, x: &[DVec2], f: usize) -> bool {
        let s = (self.scale)(f);
        let [c0, c1] = self.rest[f].jacobian(self.node[f].map(|n| x[n as usize]));
        let det = c0.perp_dot(c1);
        det.is_nan() || det <= TURNED * s * s
    }
}

/// Bytes that [`untangle`] takes.
pub const fn untangle_need(nodes: usize, faces: usize) -> usize {
    bytes_for::<u8>(nodes).saturating_add(bytes_for::<[f64; 3]>(nodes)).saturating_add(bytes_for::<u32>(faces))
}

/// Moves nodes of `x` until no face is turned over; returns how many are in the end.
pub fn untangle(x: &mut [DVec2], shapes: &Shapes, mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
    let faces = shapes.node.len();
    let free = scratch.take::<u8>(x.len())?;
    let sums = scratch.take::<[f64; 3]>(x.len())?;
    let patch = scratch.take::<u32>(faces)?;
    let goal = scratch.take::<DVec2>(x.len())?;
    goal.copy_from(x);
    for round in 0..ROUNDS {
        let mut any = false;
        for f in (0..faces).filter(|f| shapes.is_bad(x, *f)) {
            any = true;
            shapes.node[f].iter().for_each(|n| free[*n as usize] = 1);
        }
        if !any {
            return Ok(0);
        }
        if round > 0 {
            grow(free, shapes.node);
        }
        let mut count = 0;
        for (f, nodes) in shapes.node.iter().enumerate() {
            if nodes.iter().any(|n| free[*n as usize] != 0) {
                patch[count] = f as u32;
                count += 1;
            }
        }
        let patch = &patch[..count];
        for sweep in 1..=SWEEPS {
            step(x, sums, goal, free, patch, shapes);
            if sweep % LOOK == 0 && !patch.iter().any(|f| shapes.is_bad(x, *f as usize)) {
                break;
            }
        }
    }
    Ok((0..faces).filter(|f| shapes.is_bad(x, *f)).count())
}

/// Frees the nodes of all faces that have a free one.
fn grow(free: &mut [u8], node: &[[u32; 3]]) {
    for nodes in node {
        if !nodes.iter().any(|n| free[*n as usize] == 1) {
            continue;
        }
        for n in nodes {
            if free[*n as usize] == 0 {
                free[*n as usize] = 2;
            }
        }
    }
    free.iter_mut().filter(|f| **f == 2).for_each(|f| *f = 1);
}

/// One sweep.
fn step(x: &mut [DVec2], sums: &mut [[f64; 3]], goal: &[DVec2], free: &[u8], patch: &[u32], shapes: &Shapes) {
    let nodes = || patch.iter().flat_map(|f| shapes.node[*f as usize]).map(|n| n as usize);
    for n in nodes() {
        sums[n] = [goal[n].x * PULL, goal[n].y * PULL, PULL];
    }
    for f in patch.iter().map(|f| *f as usize) {
        let corners = shapes.node[f].map(|n| x[n as usize]);
        let wanted = wanted(&shapes.rest[f], corners, (shapes.scale)(f));
        for (n, w) in shapes.node[f].iter().zip(wanted) {
            let sum = &mut sums[*n as usize];
            *sum = [sum[0] + w.x, sum[1] + w.y, sum[2] + 1.0];
        }
    }
    for n in nodes().filter(|n| free[*n] != 0) {
        x[n] = DVec2::new(sums[n][0], sums[n][1]) / sums[n][2];
    }
}

/// Where the corners of a face would be, about the same middle, with singular values in bounds.
fn wanted(rest: &Rest, x: [DVec2; 3], scale: f64) -> [DVec2; 3] {
    let [c0, c1] = rest.jacobian(x).map(|c| c / scale.max(f64::MIN_POSITIVE));
    // A turn with stretch q and a mirrored turn with stretch r; singular values q + r and q - r.
    let (turn, mirror) = (DVec2::new(c0.x + c1.y, c0.y - c1.x) * 0.5, DVec2::new(c0.x - c1.y, c0.y + c1.x) * 0.5);
    let (q, r) = (sqrt(turn.dot(turn)), sqrt(mirror.dot(mirror)));
    let large = (q + r).clamp(LEAST, MOST);
    let small = (q - r).clamp(LEAST, MOST);
    let unit = |v: DVec2, size: f64| if size > 1e-12 { v / size } else { DVec2::X };
    let (t, m) = (unit(turn, q) * (0.5 * (large + small)), unit(mirror, r) * (0.5 * (large - small)));
    let columns = [DVec2::new(t.x + m.x, t.y + m.y) * scale, DVec2::new(m.y - t.y, t.x - m.x) * scale];
    let base = DVec2::new(rest.base(), 0.0);
    let top = rest.unfold(DVec2::ZERO, base);
    let at = |p: DVec2| columns[0] * p.x + columns[1] * p.y;
    let corners = [DVec2::ZERO, at(base), at(top)];
    let shift = (x[0] + x[1] + x[2] - corners[0] - corners[1] - corners[2]) / 3.0;
    corners.map(|p| p + shift)
}
