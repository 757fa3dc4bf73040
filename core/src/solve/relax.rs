//! Newton's method on the symmetric Dirichlet energy of a piece of surface, and the springs that pull it.
//!
//! Projected Newton: per-triangle Hessians made positive semi-definite (`energy`), one direct solve a step (`sparse`),
//! a step length that keeps every triangle's orientation, then backtracking to a sufficient decrease.
//! Guarantee: a start without flips stays without flips, and the energy never rises.
//! Cost: O(n^1.5) a step for n nodes; the order and the fronts are found once a call.

use super::energy::OWN_BLOCK;
use super::piece::{Piece, Stop};
use super::system::{System, add_pull, add_spring, add_triangle, graph_need};
use super::walls::{Walls, walls_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use glam::{DVec2, DVec3};

/// Share of the largest flip-free step that is taken. 0.99 lets triangles come so close to flat that later steps stall.
const STEP_SHARE: f64 = 0.8;
/// Sufficient decrease (Armijo).
const DECREASE: f64 = 1e-4;
/// Times that a step is halved before it is given up.
const HALVINGS: usize = 30;
/// Added to each diagonal entry: holds the rigid motions, which have no energy.
const HOLD: f64 = 1e-7;

/// A whole step that lowers the energy by this share of what its slope says, where a quadratic is lowered by half of it, leads well.
const WELL: f64 = 0.25;
/// Steps with the same factor at the most: near rest the Hessian changes little, and to solve with it again costs a tenth.
const AGAIN: usize = 3;

/// Triangles whose energies are summed by one task.
const CHUNK: usize = 2048;

/// Share of the least decrease below which charts count as settled without a look at the whole. Of 24 charts of 30,000
/// nodes that a split had changed little, 0.3 spares 12 of 15 factorisations that found nothing to do and skips one step of
/// 9; 0.2 spares 7 and skips none.
const SETTLED: f64 = 0.3;
/// Smaller charts are factored anyway.
const SETTLED_FROM: usize = 2000;

/// What was done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Relaxation {
    /// Energy of triangles and springs at the start.
    pub before: f64,
    /// And at the end.
    pub after: f64,
    /// Newton steps taken.
    pub steps: usize,
    /// Whether the tolerance was reached.
    pub converged: bool,
}

/// Scratch bytes for [`relax`] or a [`System`] on this many nodes, triangles and springs. The factor's size depends on
/// the graph: measured on charts of 400 to 50,000 nodes it is 15 to 23 log2(n) values a node; 32 log2(n) + 64 are held.
pub fn relax_need(nodes: usize, triangles: usize, springs: usize) -> usize {
    let log = (usize::BITS - nodes.leading_zeros()) as usize;
    let factor = nodes * (32 * log + 64) * 4;
    let fronts = nodes * (110 + 144) * 8 + 200_000;
    let graph = nodes * 190 + triangles * 40 + springs * 48;
    factor + fronts + graph + 4096 + walls_need(nodes)
}

/// Energy of a piece at `x`: triangles (psi times area) and springs. `sums` is memory, one value a chunk.
fn energy(piece: &Piece, x: &[DVec2], sums: &mut [f64], workers: &dyn Workers) -> f64 {
    for_each_chunk(workers, sums, 1, &|chunk, sum| {
        let range = chunk_of(chunk, piece.triangles.len());
        let pairs = piece.triangles[range.clone()].iter().zip(&piece.rest[range]);
        sum[0] = pairs.map(|(t, rest)| rest.weight * rest.objective(t.map(|i| x[i as usize]))).sum();
    });
    let mut sum = sums.iter().sum();
    for s in piece.springs {
        let d = x[s.a as usize] - x[s.b as usize];
        sum += s.weight * d.dot(d);
    }
    sum
}

/// Triangles of a chunk.
fn chunk_of(chunk: usize, count: usize) -> core::ops::Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(count)
}

/// Moves the free nodes of `x` to lower energy. A start with a flipped triangle is returned as it is, with infinite
/// energy.
pub fn relax(
    x: &mut [DVec2],
    piece: &Piece,
    stop: Stop,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Relaxation, ScratchTooSmall> {
    let free = piece.free;
    let sums = scratch.take::<f64>(piece.triangles.len().div_ceil(CHUNK))?;
    let mut walls = Walls::new(piece.walls, piece, &mut scratch)?;
    let pushes = scratch.take::<[f64; 5]>(if piece.walls.is_empty() { 0 } else { x.len() })?;
    walls.open(x, piece, scratch.frame())?;
    let mut now = energy(piece, x, sums, workers) + walls.energy(x);
    let mut done = Relaxation { before: now, after: now, ..Relaxation::default() };
    if free == 0 || now == f64::INFINITY || stop.steps == 0 {
        return Ok(done);
    }
    let area: f64 = piece.rest.iter().map(|r| r.area).sum();
    if settled(x, piece, stop.tolerance * area, scratch.frame())? {
        done.converged = true;
        return Ok(done);
    }
    // What only the order of elimination needs serves the steps afterwards.
    let bytes = bytes_for::<DVec3>(free) + graph_need(piece);
    let mut spare = scratch.split(bytes.max(2 * bytes_for::<DVec2>(x.len())))?;
    let mut system = {
        let mut frame = spare.frame();
        // The map is an embedding of the graph in the plane: short separators, whatever the surface does in space.
        let at = frame.take::<DVec3>(free)?;
        at.iter_mut().zip(x.iter()).for_each(|(a, x)| *a = x.extend(0.0));
        System::new(&Piece { at, ..*piece }, &mut scratch, frame)?
    };
    let step = spare.take::<DVec2>(x.len())?; // held nodes keep a zero step
    let trial = spare.take::<DVec2>(x.len())?;
    trial.copy_from(x);
    // Steps that may be taken with the last factor, where it led well.
    let mut again = 0;
    while again > 0 || done.steps < stop.steps {
        let with_last = if again > 0 {
            step_again(&mut step[..free], x, piece, &mut system, scratch.frame(), workers)?
        } else {
            None
        };
        // The step is -H^-1 g: it falls by g . H^-1 g.
        let slope = match with_last {
            Some(fall) => -fall,
            None if done.steps == stop.steps => break,
            None => {
                walls.derivatives(x, pushes);
                -newton_step(&mut step[..free], x, piece, pushes, &mut system, scratch.frame(), workers)?
            }
        };
        if slope.is_nan() || slope > -stop.tolerance * area {
            done.converged = true;
            break;
        }
        let limit = walls.limit(x, step, flip_limit(x, step, piece, sums, workers));
        let length = (limit * STEP_SHARE).min(1.0);
        let found = shorten(&mut trial[..], x, &step[..free], length, |trial, length| {
            let next = energy(piece, trial, sums, workers) + walls.energy(trial);
            (next <= now + DECREASE * length * slope).then_some(next)
        });
        let led_well = length == 1.0 && found.is_some_and(|next| next <= now + WELL * slope);
        if with_last.is_some() {
            again -= 1;
            if !led_well {
                again = 0;
                continue;
            }
        } else {
            done.steps += 1;
            again = if led_well && piece.springs.is_empty() && piece.walls.is_empty() { AGAIN } else { 0 };
        }
        let Some(next) = found else { break };
        now = next;
        x[..free].copy_from(&trial[..free]);
    }
    done.after = now;
    Ok(done)
}

/// Writes the step that the last factor makes of the gradient at `x`; returns how far the energy falls along it, or nothing where that
/// factor was not kept.
fn step_again(
    step: &mut [DVec2],
    x: &[DVec2],
    piece: &Piece,
    system: &mut System,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Option<f64>, ScratchTooSmall> {
    let right = scratch.take::<DVec2>(x.len())?;
    for (t, rest) in piece.triangles.iter().zip(piece.rest) {
        let g = rest.gradient(t.map(|i| x[i as usize]));
        for (i, g) in t.iter().zip(g.as_chunks::<2>().0) {
            right[*i as usize] -= DVec2::from_array(*g);
        }
    }
    system.solve_again(step, &right[..piece.free], scratch, workers)
}

/// Writes the Newton step of every free node; returns how far the energy falls along it.
fn newton_step(
    step: &mut [DVec2],
    x: &[DVec2],
    piece: &Piece,
    pushes: &[[f64; 5]],
    system: &mut System,
    scratch: Scratch,
    workers: &dyn Workers,
) -> Result<f64, ScratchTooSmall> {
    let free = piece.free;
    system.solve(
        step,
        |t, matrix| {
            let nodes = piece.triangles[t];
            let (g, h) = piece.rest[t].derivatives(nodes.map(|i| x[i as usize]));
            add_triangle(matrix, nodes, free, &g, &h);
        },
        |s, matrix| {
            let s = piece.springs[s];
            add_spring(matrix, s, free);
            add_pull(matrix, s, (x[s.b as usize] - x[s.a as usize]) * (2.0 * s.weight), free);
        },
        |i, matrix| {
            let [gx, gy, xx, xy, yy] = pushes.get(i as usize).copied().unwrap_or_default();
            matrix.add(i, i, [xx + HOLD, xy, xy, yy + HOLD]);
            matrix.add_vector(i, -DVec2::new(gx, gy));
        },
        scratch,
        workers,
    )
}

/// How much of `step` can be taken before a triangle flips, at most what makes a whole step. `sums` is memory, one value a chunk.
fn flip_limit(x: &[DVec2], step: &[DVec2], piece: &Piece, sums: &mut [f64], workers: &dyn Workers) -> f64 {
    for_each_chunk(workers, sums, 1, &|chunk, limit| {
        let range = chunk_of(chunk, piece.triangles.len());
        limit[0] = 1.0 / STEP_SHARE;
        for (t, rest) in piece.triangles[range.clone()].iter().zip(&piece.rest[range]) {
            limit[0] = rest.step_limit(t.map(|i| x[i as usize]), t.map(|i| step[i as usize]), limit[0]);
        }
    });
    sums.iter().copied().fold(1.0 / STEP_SHARE, f64::min)
}

/// Halves the step until `accept` answers an energy for where it leads, which `trial` then holds.
fn shorten(
    trial: &mut [DVec2],
    x: &[DVec2],
    step: &[DVec2],
    mut length: f64,
    mut accept: impl FnMut(&[DVec2], f64) -> Option<f64>,
) -> Option<f64> {
    for _ in 0..HALVINGS {
        for (to, (x, step)) in trial.iter_mut().zip(x.iter().zip(step)) {
            *to = *x + *step * length;
        }
        let accepted = accept(trial, length);
        if accepted.is_some() {
            return accepted;
        }
        length *= 0.5;
    }
    None
}

/// Whether a step promises next to nothing, told without a factorisation: the decrease that each node alone could reach,
/// g . D^-1 g with D the 2 x 2 blocks on the diagonal, is well below `least`.
fn settled(x: &[DVec2], piece: &Piece, least: f64, mut scratch: Scratch) -> Result<bool, ScratchTooSmall> {
    if !piece.springs.is_empty() || !piece.walls.is_empty() || piece.free < SETTLED_FROM {
        return Ok(false);
    }
    let sums = scratch.take::<[f64; 5]>(x.len())?; // gradient, and a block's xx, xy, yy
    for (t, rest) in piece.triangles.iter().zip(piece.rest) {
        let (g, h) = rest.derivatives(t.map(|i| x[i as usize]));
        for (k, (i, block)) in t.iter().zip(OWN_BLOCK).enumerate() {
            let sum = &mut sums[*i as usize];
            sum[0] += g[2 * k];
            sum[1] += g[2 * k + 1];
            for (s, entry) in sum[2..].iter_mut().zip(block) {
                *s += h[entry];
            }
        }
    }
    let mut fall = 0.0;
    for [gx, gy, xx, xy, yy] in &sums[..piece.free] {
        let det = xx * yy - xy * xy;
        fall += (yy * gx * gx - 2.0 * xy * gx * gy + xx * gy * gy) / det.max(f64::MIN_POSITIVE);
    }
    Ok(fall < SETTLED * least)
}
