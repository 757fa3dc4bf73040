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
    let length = |a: u32, b: u32| {
        let d = piece.at[a as usize] - piece.at[b as usize];
        sqrt(d.dot(d)).max(1e-12)
    };
    let area: f64 = piece.rest.iter().map(|r| r.area).sum();
    let total: f64 = border.iter().map(|[a, b]| length(*a, *b)).sum();
    let radius = sqrt(area / core::f64::consts::PI);
    let mut along = 0.0;
    for [a, b] in border {
        let angle = along / total * core::f64::consts::TAU;
        x[*a as usize] = DVec2::new(cos(angle), sin(angle)) * radius;
        along += length(*a, *b);
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
    let length = |a: u32, b: u32| {
        let d = piece.at[a as usize] - piece.at[b as usize];
        sqrt(d.dot(d)).max(1e-12)
    };
    // Each inner edge appears in two triangles, once each way: half its stiffness from each.
    let springs = scratch.take::<Spring>(3 * piece.triangles.len())?;
    for (three, t) in springs.as_chunks_mut::<3>().0.iter_mut().zip(piece.triangles) {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            three[i] = Spring { a, b, weight: 0.5 / length(a, b) };
        }
    }
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
        let here = &*x;
        let pull = |s: &Spring| (here[s.b as usize] - here[s.a as usize]) * (2.0 * s.weight);
        right.fill(DVec2::ZERO);
        for s in springs.springs {
            right[s.a as usize] += pull(s);
            right[s.b as usize] -= pull(s);
        }
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
    let springs = scratch.take::<Spring>(3 * piece.triangles.len())?;
    for (three, t) in springs.as_chunks_mut::<3>().0.iter_mut().zip(piece.triangles) {
        let at = t.map(|i| piece.at[i as usize]);
        for i in 0..3 {
            let (b, c) = ((i + 1) % 3, (i + 2) % 3);
            three[i] = Spring { a: t[i], b: t[b], weight: cotangent(at[i] - at[c], at[b] - at[c]) };
        }
    }
    let springs = Piece { triangles: &[], rest: &[], free: x.len(), at: piece.at, springs, walls: &[] };
    let temporary = scratch.split(graph_need(&springs))?;
    let mut system = System::new(&springs, &mut scratch, temporary)?;
    let step = scratch.take::<DVec2>(x.len())?;
    let right = scratch.take::<DVec2>(x.len())?;
    for (three, lies) in springs.springs.as_chunks::<3>().0.iter().zip(sides) {
        for i in 0..3 {
            let s = &three[i];
            let off = (x[s.b as usize] - x[s.a as usize]) - (lies[(i + 1) % 3] - lies[i]);
            right[s.a as usize] += off * (2.0 * s.weight);
            right[s.b as usize] -= off * (2.0 * s.weight);
        }
    }
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

/// Cotangent of the angle between two sides, within what [`weld`] reckons with.
fn cotangent(u: DVec3, v: DVec3) -> f64 {
    let n = u.cross(v);
    (u.dot(v) / sqrt(n.dot(n)).max(f64::MIN_POSITIVE)).clamp(COTANGENT[0], COTANGENT[1])
}

/// Whether no triangle is turned over or flat.
fn is_upright(x: &[DVec2], piece: &Piece) -> bool {
    piece.triangles.iter().all(|t| {
        let [a, b, c] = t.map(|i| x[i as usize]);
        (b - a).perp_dot(c - a) > 0.0
    })
}
