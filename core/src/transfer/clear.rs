//! The map onto the grid, without flips and overlaps: what lies on something else yields, a little more each time.
//!
//! Faces that were carried on beyond their chart's border come back to it in steps; where that is not enough, and where nothing was
//! carried on, nodes move towards the middle of their neighbours. After every step faces that are turned over are turned back,
//! the map is rounded to the grid, and overlaps are looked for there exactly. The best round is kept; where that has no fault, what gave way without
//! need goes back. Cost: a search for overlaps a round.

use super::source::SourceAtlas;
use super::targets::Targets;
use super::untangle::{Shapes, untangle, untangle_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::finish::snap::{straighten, straighten_need};
use crate::mesh::view::NONE;
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle, doubled_area};
use crate::plane::overlap::{overlaps, overlaps_need};
use glam::DVec2;

/// Rounds at the most.
const ROUNDS: usize = 40;
/// How much of what lies beyond the border is left after so many steps.
const LEFT: [f64; 4] = [1.0, 0.6, 0.3, 0.0];
/// How far a node goes towards the middle of its neighbours in each step after those, and at the most.
const INWARDS: f64 = 0.1;
const FARTHEST: f64 = 0.9;

/// Rounds after which the nodes of faces that still overlap go to the middle of their neighbours, and sweeps of that.
const PATIENCE: usize = 12;
const SWEEPS: usize = 60;
/// Rounds in which nodes go back.
const ROUNDS_BACK: usize = 24;

/// What the map is of.
#[derive(Clone, Copy)]
pub struct CarriedMap<'s> {
    /// The faces.
    pub shapes: Shapes<'s>,
    /// Chart of the source that each face belongs to.
    pub chart: &'s dyn Fn(usize) -> u32,
    /// The source.
    pub source: &'s SourceAtlas<'s>,
    /// Whether the map stays in the unit square.
    pub in_square: bool,
    /// Whether each face belongs to a small piece of the mesh, which yields alone to a larger one: a flap of no thickness has no place of its own, and
    /// all that it lies on would give way.
    pub small: &'s dyn Fn(usize) -> bool,
}

/// What was reached.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cleared {
    /// Faces that are turned over or without area on the grid.
    pub flipped: usize,
    /// Faces that overlap another on the grid.
    pub overlapping: usize,
    /// Those of them that belong to small pieces.
    pub small: usize,
    /// Corners outside of the unit square, where the source has none.
    pub outside: usize,
}

impl Cleared {
    fn faults(&self) -> usize {
        self.flipped.saturating_add(self.overlapping).saturating_add(self.outside)
    }
}

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
) -> Result<Cleared, ScratchTooSmall> {
    let (nodes, faces) = (x.len(), atlas.shapes.node.len());
    let level = scratch.take::<u8>(nodes)?;
    let loose = scratch.take::<u8>(nodes)?;
    let middle = scratch.take::<DVec2>(nodes)?;
    middles(middle, targets.fitted, atlas.shapes.node, scratch.frame())?;
    let partner = scratch.take::<u32>(faces)?;
    let triangles = scratch.take::<GridTriangle>(faces)?;
    let best = scratch.take::<GridPoint>(nodes)?;
    let mut done = Cleared { overlapping: usize::MAX, ..Cleared::default() };
    for round in 0..ROUNDS {
        for (n, x) in x.iter_mut().enumerate() {
            *x = place(targets.inner[n], targets.fitted[n], middle[n], level[n]);
        }
        smooth(x, loose, atlas.shapes.node, scratch.frame())?;
        untangle(x, &atlas.shapes, scratch.frame())?;
        let flipped = onto_grid(x, grid, atlas, scratch.frame())?;
        write(triangles, grid, atlas);
        let overlapping = overlaps(partner, triangles, scratch.frame(), workers)?;
        let mut outside = 0;
        for (n, p) in atlas.shapes.node.as_flattened().iter().zip(triangles.as_flattened()) {
            if atlas.in_square && !is_inside(*p) {
                yield_at(level, *n, targets);
                outside += 1;
            }
        }
        let small = partner.iter().enumerate().filter(|(f, p)| **p != NONE && (atlas.small)(*f)).count();
        let now = Cleared { flipped, overlapping, small, outside };
        if now.faults() < done.faults() {
            done = now;
            best.copy_from(grid);
        }
        if overlapping + outside == 0 {
            break;
        }
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
    if done.faults() == 0 {
        go_back(grid, best, loose, triangles, partner, targets, atlas, scratch, workers)?;
    }
    Ok(done)
}

/// Lets nodes of the map `best`, which has no fault, go back to where they fit best: those of faces that would be turned over, overlap or leave the
/// square stay, until no face would.
#[allow(clippy::too_many_arguments)]
fn go_back(
    grid: &mut [GridPoint],
    best: &[GridPoint],
    stays: &mut [u8],
    triangles: &mut [GridTriangle],
    partner: &mut [u32],
    targets: &Targets,
    atlas: &CarriedMap,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    stays.fill(0);
    for _ in 0..ROUNDS_BACK {
        for (n, g) in grid.iter_mut().enumerate() {
            *g = if stays[n] != 0 { best[n] } else { GridPoint::snap(targets.fitted[n], GRID_BITS) };
        }
        if *grid == *best {
            return Ok(());
        }
        write(triangles, grid, atlas);
        overlaps(partner, triangles, scratch.frame(), workers)?;
        let mut hinders = false;
        for ((nodes, t), p) in atlas.shapes.node.iter().zip(triangles.iter()).zip(partner.iter()) {
            if is_turned(nodes, grid) || *p != NONE || atlas.in_square && !t.iter().all(|p| is_inside(*p)) {
                hinders = true;
                nodes.iter().for_each(|n| stays[*n as usize] = 1);
            }
        }
        if !hinders {
            return Ok(());
        }
    }
    grid.copy_from(best);
    Ok(())
}

/// Whether a face has no positive area on the grid, as seen.
fn is_turned(nodes: &[u32; 3], grid: &[GridPoint]) -> bool {
    doubled_area(&nodes.map(|n| grid[n as usize])) <= 0
}

/// The faces as they are written.
fn write(triangles: &mut [GridTriangle], grid: &[GridPoint], atlas: &CarriedMap) {
    for (f, t) in triangles.iter_mut().enumerate() {
        *t = atlas.shapes.node[f].map(|n| written(grid[n as usize], atlas, f));
    }
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

/// Rounds the map to the grid, still as seen; returns how many faces have no positive area there.
fn onto_grid(
    x: &[DVec2],
    grid: &mut [GridPoint],
    atlas: &CarriedMap,
    scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    grid.iter_mut().zip(x).for_each(|(g, x)| *g = GridPoint::snap(*x, GRID_BITS));
    if atlas.in_square {
        return straighten(grid, atlas.shapes.node, scratch);
    }
    Ok(atlas.shapes.node.iter().filter(|nodes| is_turned(nodes, grid)).count())
}

/// A point of face `f` as it is written.
pub fn written(p: GridPoint, atlas: &CarriedMap, f: usize) -> GridPoint {
    match atlas.source.mirrored[(atlas.chart)(f) as usize] {
        0 => p,
        _ => GridPoint::new((1 << GRID_BITS) - p.x(), p.y()),
    }
}

fn is_inside(p: GridPoint) -> bool {
    let room = 0..=1 << GRID_BITS;
    room.contains(&p.x()) && room.contains(&p.y())
}
