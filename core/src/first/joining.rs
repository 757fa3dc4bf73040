//! Border loops, tips and handles of a component joined to one cut graph, by growing cheapest paths (Takahashi, Matsuyama 1980).
//!
//! Guarantee: a component whose handles are cut becomes one disk. Cost: O(n log n).

use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::charts::paths::Paths;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};

/// Joins every border loop and tip of a component to its cut graph by cheapest paths.
#[allow(clippy::too_many_arguments)]
pub(super) fn join(
    cut: &mut [u8],
    joined: &mut [u8],
    tip: &[u8],
    loops: &[u32],
    component: &[u32],
    count: usize,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = joined.len();
    // A component without handles starts at its first border loop, or at its first tip.
    let started = scratch.take::<u8>(count)?;
    for v in 0..n {
        started[component[v] as usize] |= joined[v];
    }
    for pass in 0..2 {
        for v in 0..n {
            let start = &mut started[component[v] as usize];
            if *start == 0 && if pass == 0 { loops[v] != NONE } else { tip[v] != 0 } {
                *start = 1;
                joined[v] = 1;
            }
        }
    }
    let loop_next = scratch.take_filled::<u32>(n, NONE)?; // next vertex of the same loop
    let loop_first = scratch.take_filled::<u32>(n, NONE)?; // by loop
    for v in 0..n {
        if loops[v] != NONE {
            loop_next[v] = loop_first[loops[v] as usize];
            loop_first[loops[v] as usize] = v as u32;
        }
    }
    let mut paths = Paths::new(n, &mut scratch)?;
    let sources = scratch.take::<u32>(n)?;
    let mut len = 0;
    for v in 0..n as u32 {
        if joined[v as usize] != 0 {
            sources[len] = v;
            len += 1;
        }
    }
    let open_loop = scratch.take::<u8>(n)?; // by loop: joined already
    paths.grow(
        surface,
        sources[..len].iter().copied(),
        |c| if surface.twin[c as usize] == NONE { 0.0 } else { surface.cost[c as usize] },
        |v, reached| {
            let on_loop = loops[v as usize] != NONE && open_loop[loops[v as usize] as usize] == 0;
            let is_tip = tip[v as usize] != 0 && reached.via[v as usize] != NONE;
            if !on_loop && !is_tip {
                return;
            }
            let mut at = v;
            while reached.via[at as usize] != NONE {
                let c = reached.via[at as usize];
                let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
                if surface.twin[c as usize] != NONE {
                    surface.set_cut(cut, c, true);
                }
                reached.source(at);
                at = if a == at { b } else { a };
            }
            if on_loop {
                let mut w = loop_first[loops[v as usize] as usize];
                open_loop[loops[v as usize] as usize] = 1;
                while w != NONE {
                    reached.source(w);
                    w = loop_next[w as usize];
                }
            }
        },
    );
    Ok(())
}
