//! First flattening: each disk onto a circle by springs (Tutte 1963; Floater 1997).
//!
//! Guarantee in exact arithmetic: no flips, no overlap. In f64, charts with long thin limbs can lose that to rounding:
//! the caller looks at the energy of the result. Cost: one sparse solve.

use super::relax::{Piece, Spring, System, add_spring};
use super::surface::Surface;
use crate::base::real::{cos, sin, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::mesh::view::{NONE, next};
use glam::DVec2;

/// Writes the UV of every corner: each chart on a disk of its own area around the origin.
pub fn tutte(uv: &mut [DVec2], surface: &Surface, cut: &[u8], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let corners = surface.mesh.corner_count();
    let node = scratch.take::<u32>(corners)?;
    let count = surface.wedges(cut, node);
    let number = scratch.take_filled::<u32>(count, NONE)?; // free nodes first
    for c in 0..corners as u32 {
        if surface.is_open(cut, c) {
            number[node[c as usize] as usize] = 0;
            number[node[next(c) as usize] as usize] = 0;
        }
    }
    let held = number.iter().filter(|n| **n == 0).count();
    let (mut at_free, mut at_held) = (0, (count - held) as u32);
    for n in number.iter_mut() {
        let slot = if *n == NONE { &mut at_free } else { &mut at_held };
        *n = *slot;
        *slot += 1;
    }
    let free = count - held;
    node.iter_mut().for_each(|n| *n = number[*n as usize]);
    let x = scratch.take::<DVec2>(count)?;
    place_borders(x, node, surface, cut, scratch.frame())?;
    let springs = scratch.take::<Spring>(corners)?;
    let mut len = 0;
    for c in 0..corners as u32 {
        if let Some(t) = surface.across(cut, c)
            && c < t
        {
            let length = surface.length(c).max(1e-12);
            springs[len] = Spring { a: node[c as usize], b: node[next(c) as usize], weight: 1.0 / length };
            len += 1;
        }
    }
    let springs = &springs[..len];
    let at = scratch.take::<glam::DVec3>(count)?;
    for c in 0..corners {
        at[node[c] as usize] = surface.mesh.position(c as u32);
    }
    let piece = Piece { triangles: &[], rest: &[], free, at, springs };
    let mut system = System::new(&piece, &mut scratch)?;
    system.factor(|_, _| {}, |s, matrix| add_spring(matrix, springs[s], free), 0.0, scratch.frame())?;
    let rhs = scratch.take::<DVec2>(free)?;
    for s in springs {
        for (a, b) in [(s.a, s.b), (s.b, s.a)] {
            if (a as usize) < free && b as usize >= free {
                rhs[a as usize] += x[b as usize] * (2.0 * s.weight);
            }
        }
    }
    system.solve(rhs, scratch.frame())?;
    x[..free].copy_from_slice(rhs);
    for (u, n) in uv.iter_mut().zip(node.iter()) {
        *u = x[*n as usize];
    }
    Ok(())
}

/// Puts each chart's border on a circle of the chart's area, by arc length.
fn place_borders(
    x: &mut [DVec2],
    node: &[u32],
    surface: &Surface,
    cut: &[u8],
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let corners = surface.mesh.corner_count();
    let faces = surface.mesh.faces.len();
    let chart = scratch.take::<u32>(faces)?;
    let queue = scratch.take::<u32>(faces)?;
    let chart_count = surface.charts(cut, chart, queue);
    let area = scratch.take::<f64>(chart_count)?;
    for f in 0..faces {
        area[chart[f] as usize] += surface.rest[f].area;
    }
    let seen = scratch.take::<u8>(corners)?;
    let following = |c: u32| {
        let mut out = next(c);
        while let Some(t) = surface.across(cut, out) {
            out = next(t);
        }
        out
    };
    for first in 0..corners as u32 {
        if seen[first as usize] != 0 || !surface.is_open(cut, first) {
            continue;
        }
        let (mut total, mut at) = (0.0, first);
        while seen[at as usize] == 0 {
            seen[at as usize] = 1;
            total += surface.length(at).max(1e-12);
            at = following(at);
        }
        let radius = sqrt(area[chart[(first / 3) as usize] as usize] / core::f64::consts::PI);
        let mut along = 0.0;
        loop {
            let angle = along / total * core::f64::consts::TAU;
            x[node[at as usize] as usize] = DVec2::new(cos(angle), sin(angle)) * radius;
            along += surface.length(at).max(1e-12);
            at = following(at);
            if at == first {
                break;
            }
        }
    }
    Ok(())
}
