//! The map onto the grid, without flips and overlaps: what lies on something else yields, a little more each time.
//!
//! Faces that were carried on beyond their chart's border come back to it in steps; where that is not enough, and where nothing was
//! carried on, nodes move towards the middle of their neighbours. After every step faces that are turned over are turned back,
//! the map is rounded to the grid, and overlaps are looked for there exactly. The best round is kept. Cost: a search for overlaps a round.

use super::carried_map::CarriedMap;
use super::targets::Targets;
use super::untangle::{untangle, untangle_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::finish::snap::{straighten, straighten_need};
use crate::mesh::view::NONE;
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle};
use crate::plane::overlap::overlaps_need;
use glam::DVec2;

/// Rounds at the most.
const ROUNDS: usize = 40;
/// Rounds that may pass without fewer faults.
const IN_VAIN: usize = 16;
/// How much of what lies beyond the border is left after so many steps.
const LEFT: [f64; 4] = [1.0, 0.6, 0.3, 0.0];
/// How far a node goes towards the middle of its neighbours in each step after those, and at the most.
const INWARDS: f64 = 0.1;
const FARTHEST: f64 = 0.9;

/// Rounds after which the nodes of faces that still overlap go to the middle of their neighbours, and sweeps of that.
const PATIENCE: usize = 12;
const SWEEPS: usize = 60;

/// Bytes that [`clear`] takes.
pub const fn clear_need(nodes: usize, faces: usize) -> usize {
    bytes_for::<[u8; 2]>(nodes)
        .saturating_add(bytes_for::<GridPoint>(nodes))
        .saturating_add(bytes_for::<DVec2>(nodes).saturating_mul(3))
        .saturating_add(bytes_for::<[f64; 3]>(nodes))
        .saturating_add(bytes_for::<f64>(nodes))
        .saturating_add(bytes_for::<u32>(faces))
        .saturating_add(bytes_for::<GridTriangle>(faces))
        .saturating_add(untangle_need(nodes, faces))
        .saturating_add(straighten_need(nodes, faces))
        .saturating_add(overlaps_need(faces))
}

/// Writes the map of the nodes, as seen, from their targets to `grid`; `x` is memory.
pub fn clear(
    x: &mut [DVec2],
    grid: &mut [GridPoint],
    targets: &Targets,
    atlas: &CarriedMap,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let (nodes, faces) = (x.len(), atlas.shapes.node.len());
    let level = scratch.take::<u8>(nodes)?;
    let loose = scratch.take::<u8>(nodes)?;
    let middle = scratch.take::<DVec2>(nodes)?;
    middles(middle, targets.fitted, atlas.shapes.node, scratch.frame())?;
    let partner = scratch.take::<u32>(faces)?;
    let triangles = scratch.take::<GridTriangle>(faces)?;
    let best = scratch.take::<GridPoint>(nodes)?;
    let (mut fewest, mut in_vain) = (usize::MAX, 0);
    for round in 0..ROUNDS {
        for (n, x) in x.iter_mut().enumerate() {
            *x = place(targets.inner[n], targets.fitted[n], middle[n], level[n]);
        }
        smooth(x, loose, atlas.shapes.node, scratch.frame())?;
        untangle(x, &atlas.shapes, scratch.frame())?;
        onto_grid(x, grid, atlas, scratch.frame())?;
        let faults = atlas.look(triangles, partner, grid, scratch.frame(), workers)?;
        for (n, p) in atlas.shapes.node.as_flattened().iter().zip(triangles.as_flattened()) {
            if atlas.is_outside(*p) {
                yield_at(level, *n, targets);
            }
        }
        if faults.count() < fewest {
            (fewest, in_vain) = (faults.count(), 0);
            best.copy_from(grid);
        }
        if faults.overlapping + faults.outside == 0 || in_vain == IN_VAIN {
            break;
        }
        in_vain += 1;
        for (f, p) in partner.iter_mut().enumerate() {
            if *p != NONE && (atlas.small)(*p as usize) && !(atlas.small)(f) {
                *p = NONE; // what lies on something small stays
            }
        }
        step_back(level, partner, atlas, targets);
        if round >= PATIENCE {
            loosen(loose, partner, atlas.shapes.node, round % 3 == 2);
        }
    }
    grid.copy_from(best);
    Ok(())
}

/// Middle of the neighbours of each node.
fn middles(middle: &mut [DVec2], x: &[DVec2], node: &[[u32; 3]], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let count = scratch.take::<f64>(x.len())?;
    for nodes in node {
        for i in 0..3 {
            let n = nodes[i] as usize;
            middle[n] += x[nodes[(i + 1) % 3] as usize] + x[nodes[(i + 2) % 3] as usize];
            count[n] += 2.0;
        }
    }
    middle.iter_mut().zip(count.iter()).for_each(|(m, c)| *m /= c.max(1.0));
    Ok(())
}

/// Lets go of the nodes of faces that overlap, and with `wider` of their neighbours.
fn loosen(loose: &mut [u8], partner: &[u32], node: &[[u32; 3]], wider: bool) {
    for (nodes, _) in node.iter().zip(partner).filter(|(_, p)| **p != NONE) {
        nodes.iter().for_each(|n| loose[*n as usize] = 1);
    }
    if wider {
        // 2 for those of this ring, so that it grows by one.
        for nodes in node {
            if nodes.iter().any(|n| loose[*n as usize] == 1) {
                for n in nodes {
                    let own = &mut loose[*n as usize];
                    *own = if *own == 0 { 2 } else { *own };
                }
            }
        }
        loose.iter_mut().filter(|l| **l == 2).for_each(|l| *l = 1);
    }
}

/// Brings the loose nodes to the middle of their neighbours, as springs do: what winds more than once about a node comes apart.
fn smooth(x: &mut [DVec2], loose: &[u8], node: &[[u32; 3]], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    if !loose.contains(&1) {
        return Ok(());
    }
    let sums = scratch.take::<[f64; 3]>(x.len())?;
    for _ in 0..SWEEPS {
        sums.fill([0.0; 3]);
        for nodes in node.iter().filter(|nodes| nodes.iter().any(|n| loose[*n as usize] != 0)) {
            for i in 0..3 {
                let (p, q) = (x[nodes[(i + 1) % 3] as usize], x[nodes[(i + 2) % 3] as usize]);
                let sum = &mut sums[nodes[i] as usize];
                *sum = [sum[0] + p.x + q.x, sum[1] + p.y + q.y, sum[2] + 2.0];
            }
        }
        for ((x, sum), _) in x.iter_mut().zip(sums.iter()).zip(loose).filter(|(_, loose)| **loose != 0) {
            *x = DVec2::new(sum[0], sum[1]) / sum[2].max(1.0);
        }
    }
    Ok(())
}

/// Where a node is after `level` steps back.
fn place(inner: DVec2, fitted: DVec2, middle: DVec2, level: u8) -> DVec2 {
    let step = level as usize;
    let base = if step == 0 { fitted } else { inner.lerp(fitted, LEFT[step.min(LEFT.len() - 1)]) };
    let more = step.saturating_sub(LEFT.len() - 1) as f64;
    base.lerp(middle, (INWARDS * more).min(FARTHEST))
}

/// Whether a node was carried on beyond its chart's border by more than a grid step.
fn is_beyond(n: usize, targets: &Targets) -> bool {
    targets.inner[n].distance_squared(targets.fitted[n]) > 1e-13
}

fn yield_at(level: &mut [u8], n: u32, targets: &Targets) {
    let own = &mut level[n as usize];
    let last = LEFT.len() as u8 - 1;
    *own = if *own < last && !is_beyond(n as usize, targets) { last + 1 } else { own.saturating_add(1) };
}

/// One step back for the nodes of faces that overlap: for those beyond the border, or where there is none left for all.
fn step_back(level: &mut [u8], partner: &[u32], atlas: &CarriedMap, targets: &Targets) {
    let (last, node) = (LEFT.len() as u8 - 1, atlas.shapes.node);
    for (f, p) in partner.iter().enumerate().filter(|(_, p)| **p != NONE) {
        let stays = (atlas.small)(f) && !(atlas.small)(*p as usize);
        let both = || node[f].into_iter().chain(node[*p as usize]).take(if stays { 3 } else { 6 });
        let may_yield = |level: &[u8], n: u32| is_beyond(n as usize, targets) && level[n as usize] < last;
        if both().any(|n| may_yield(level, n)) {
            for n in both() {
                if may_yield(level, n) {
                    yield_at(level, n, targets);
                }
            }
        } else if (*p as usize) > f || partner[*p as usize] != f as u32 {
            both().for_each(|n| yield_at(level, n, targets));
        }
    }
}

/// Rounds the map to the grid, still as seen.
fn onto_grid(x: &[DVec2], grid: &mut [GridPoint], atlas: &CarriedMap, scratch: Scratch) -> Result<(), ScratchTooSmall> {
    grid.iter_mut().zip(x).for_each(|(g, x)| *g = GridPoint::snap(*x, GRID_BITS));
    if atlas.in_square {
        straighten(grid, atlas.shapes.node, scratch)?;
    }
    Ok(())
}
