//! First flattening: a disk onto a circle by springs (Tutte 1963; Floater 1997).
//!
//! Guarantee in exact arithmetic: no flips, no overlap. In f64, charts with long thin limbs can lose that to rounding:
//! the caller looks at the energy of the result. Cost: one sparse solve.

use super::piece::{Piece, Spring};
use super::sparse::front_matrix::FrontMatrix;
use super::system::{System, add_spring, graph_need};
use crate::base::real::{cos, sin, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::mesh::view::NONE;
use glam::{DVec2, DVec3};

/// Least and most cotangent of an angle that [`weld`] reckons with.
const COTANGENT: [f64; 2] = [0.05, 20.0];
/// Holds where the piece stands, which no spring does.
const HOLD: f64 = 1e-7;

/// Writes `x` for a piece without inner nodes: its triangles hang together like a tree, so each is laid down congruent
/// beside the one before it. `beside` holds the triangle across each half-edge, or `NONE`.
pub fn unfold(
    x: &mut [DVec2],
    piece: &Piece,
    beside: &[[u32; 3]],
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let placed = scratch.take::<u8>(beside.len())?;
    let queue = scratch.take::<u32>(beside.len())?;
    let Some(first) = piece.triangles.first() else { return Ok(()) };
    let base = DVec2::new(piece.rest[0].base(), 0.0);
    x[first[0] as usize] = DVec2::ZERO;
    x[first[1] as usize] = base;
    x[first[2] as usize] = piece.rest[0].unfold(DVec2::ZERO, base);
    placed[0] = 1;
    let (mut head, mut tail) = (0, 1);
    while head < tail {
        let t = queue[head] as usize;
        head += 1;
        for g in beside[t].iter().copied().filter(|g| *g != NONE) {
            if placed[g as usize] != 0 {
                continue;
            }
            placed[g as usize] = 1;
            queue[tail] = g;
            tail += 1;
            let (mut nodes, mut rest) = (piece.triangles[g as usize], piece.rest[g as usize]);
            let Some(from) = beside[g as usize].iter().position(|b| *b as usize == t) else { continue };
            for _ in 0..from {
                nodes = [nodes[1], nodes[2], nodes[0]];
                rest = rest.turned();
            }
            x[nodes[2] as usize] = rest.unfold(x[nodes[0] as usize], x[nodes[1] as usize]);
        }
    }
    Ok(())
}

/// Writes `x`: the border on a circle of the piece's area by arc length, nodes `0..inner` at the balance of springs of
/// stiffness 1 / length. `border` lists the border edges from node to node, in order; its nodes are `inner..`.
pub fn tutte(
    x: &mut [DVec2],
    piece: &Piece,
    inner: usize,
    border: &[[u32; 2]],
    scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let area: f64 = piece.rest.iter().map(|r| r.area).sum();
    let total: f64 = border.iter().map(|[a, b]| length(piece, *a, *b)).sum();
    let radius = sqrt(area / core::f64::consts::PI);
    let mut along = 0.0;
    for [a, b] in border {
        let angle = along / total * core::f64::consts::TAU;
        x[*a as usize] = DVec2::new(cos(angle), sin(angle)) * radius;
        along += length(piece, *a, *b);
    }
    balance(x, piece, inner, scratch, workers)
}

/// Puts nodes `0..inner` at the balance of springs of stiffness 1 / length; the others stay.
pub fn balance(
    x: &mut [DVec2],
    piece: &Piece,
    inner: usize,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    if inner == 0 {
        return Ok(());
    }
    // Each inner edge appears in two triangles, once each way: half its stiffness from each.
    let springs = edge_springs(piece, &mut scratch, |t, [i, j, _]| 0.5 / length(piece, t[i], t[j]))?;
    let springs = Piece { triangles: &[], rest: &[], free: inner, at: piece.at, springs, walls: &[] };
    let temporary = scratch.split(graph_need(&springs))?;
    let mut system = System::new(&springs, &mut scratch, temporary)?;
    // Later rounds correct the factor's single precision. Where the first has left no triangle turned, the second is as good
    // as exact; limbs, whose triangles become very small, take the third.
    let mut rounds = 3;
    let step = scratch.take::<DVec2>(inner)?;
    let right = scratch.take::<DVec2>(x.len())?;
    x[..inner].fill(DVec2::ZERO);
    let mut round = 0;
    while round < rounds {
        pulls(right, springs.springs, x, |_| DVec2::ZERO);
        let again = round > 0 && system.solve_again(step, &right[..inner], scratch.frame(), workers)?.is_some();
        if !again {
            let spring = |s: usize, matrix: &mut FrontMatrix| add_spring(matrix, springs.springs[s], inner);
            let node = |i: u32, matrix: &mut FrontMatrix| matrix.add_vector(i, right[i as usize]);
            system.solve(step, |_, _| {}, spring, node, scratch.frame(), workers)?;
        }
        for (x, s) in x.iter_mut().zip(step.iter()) {
            *x += *s;
        }
        round += 1;
        if round == 1 && is_upright(x, piece) {
            rounds = 2;
        }
    }
    Ok(())
}

/// Writes `x` where all triangles are as near as can be to what `sides` says of each: where its corners were, before what they
/// share was torn apart or brought together. One step of fitting Jacobians (Liu et al. 2008: the global step), with the weights
/// of angles held positive. Answers whether no triangle is turned over; where one is, `x` is no start.
pub fn weld(
    x: &mut [DVec2],
    piece: &Piece,
    sides: &[[DVec2; 3]],
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    let at = |i: u32| piece.at[i as usize];
    let weight = |t: [u32; 3], [i, j, k]: [usize; 3]| cotangent(at(t[i]) - at(t[k]), at(t[j]) - at(t[k]), COTANGENT);
    let springs = edge_springs(piece, &mut scratch, weight)?;
    let springs = Piece { triangles: &[], rest: &[], free: x.len(), at: piece.at, springs, walls: &[] };
    let temporary = scratch.split(graph_need(&springs))?;
    let mut system = System::new(&springs, &mut scratch, temporary)?;
    let step = scratch.take::<DVec2>(x.len())?;
    let right = scratch.take::<DVec2>(x.len())?;
    pulls(right, springs.springs, x, |s| sides[s / 3][(s + 1) % 3] - sides[s / 3][s % 3]);
    let nodes = x.len();
    let spring = |s: usize, matrix: &mut FrontMatrix| add_spring(matrix, springs.springs[s], nodes);
    let node = |i: u32, matrix: &mut FrontMatrix| {
        matrix.add(i, i, [HOLD, 0.0, 0.0, HOLD]);
        matrix.add_vector(i, right[i as usize]);
    };
    system.solve(step, |_, _| {}, spring, node, scratch.frame(), workers)?;
    x.iter_mut().zip(step.iter()).for_each(|(x, s)| *x += *s);
    Ok(is_upright(x, piece))
}

/// Springs along the edges of all triangles, three each; `weight` takes a triangle's nodes, and the places in it of an edge's ends
/// and of the node across.
pub(super) fn edge_springs<'s>(
    piece: &Piece,
    keep: &mut Scratch<'s>,
    weight: impl Fn([u32; 3], [usize; 3]) -> f64,
) -> Result<&'s [Spring], ScratchTooSmall> {
    let springs = keep.take::<Spring>(3 * piece.triangles.len())?;
    for (three, t) in springs.as_chunks_mut::<3>().0.iter_mut().zip(piece.triangles) {
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            three[i] = Spring { a: t[i], b: t[j], weight: weight(*t, [i, j, k]) };
        }
    }
    Ok(springs)
}

/// Writes how springs pull each node at `x`, where spring s wants its far end `wanted(s)` away from its first.
fn pulls(right: &mut [DVec2], springs: &[Spring], x: &[DVec2], wanted: impl Fn(usize) -> DVec2) {
    right.fill(DVec2::ZERO);
    for (i, s) in springs.iter().enumerate() {
        let pull = ((x[s.b as usize] - x[s.a as usize]) - wanted(i)) * (2.0 * s.weight);
        right[s.a as usize] += pull;
        right[s.b as usize] -= pull;
    }
}

/// Length of an edge, never zero.
fn length(piece: &Piece, a: u32, b: u32) -> f64 {
    let d = piece.at[a as usize] - piece.at[b as usize];
    sqrt(d.dot(d)).max(1e-12)
}

/// Cotangent of the angle between two sides, within `limits`.
pub(super) fn cotangent(u: DVec3, v: DVec3, limits: [f64; 2]) -> f64 {
    let n = u.cross(v);
    (u.dot(v) / sqrt(n.dot(n)).max(f64::MIN_POSITIVE)).clamp(limits[0], limits[1])
}

/// Whether no triangle is turned over or flat.
fn is_upright(x: &[DVec2], piece: &Piece) -> bool {
    piece.triangles.iter().all(|t| {
        let [a, b, c] = t.map(|i| x[i as usize]);
        (b - a).perp_dot(c - a) > 0.0
    })
}
