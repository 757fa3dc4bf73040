//! First flattening: a disk onto a circle by springs (Tutte 1963; Floater 1997).
//!
//! Guarantee in exact arithmetic: no flips, no overlap. In f64, charts with long thin limbs can lose that to rounding:
//! the caller looks at the energy of the result. Cost: one sparse solve.

use super::piece::{Piece, Spring};
use super::sparse::front_matrix::FrontMatrix;
use super::system::{System, add_pull, add_spring, graph_need};
use crate::base::real::{cos, sin, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::mesh::view::NONE;
use glam::DVec2;

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
    mut scratch: Scratch,
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
    if inner == 0 {
        return Ok(());
    }
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
    let upright = |x: &[DVec2]| {
        piece.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| x[i as usize]);
            (b - a).perp_dot(c - a) > 0.0
        })
    };
    let mut rounds = 3;
    let step = scratch.take::<DVec2>(inner)?;
    x[..inner].fill(DVec2::ZERO);
    let mut round = 0;
    while round < rounds {
        let here = &*x;
        let spring = |s: usize, matrix: &mut FrontMatrix| {
            let s = springs.springs[s];
            add_spring(matrix, s, inner);
            add_pull(matrix, s, (here[s.b as usize] - here[s.a as usize]) * (2.0 * s.weight), inner);
        };
        system.solve(step, |_, _| {}, spring, |_, _| {}, scratch.frame(), workers)?;
        for (x, s) in x.iter_mut().zip(step.iter()) {
            *x += *s;
        }
        round += 1;
        if round == 1 && upright(x) {
            rounds = 2;
        }
    }
    Ok(())
}
