//! What cuts cost on a decimated mesh: the cheapest way there on the mesh it came from.
//!
//! One Dijkstra from all kept vertices at once parts the fine mesh into cells; a coarse edge costs what the cheapest path
//! costs that runs in the two cells of its ends. So a search on the coarse mesh sees creases and folds between its
//! vertices, where `transfer` will lay the paths.
//! Limit: cells of two ends that do not touch say nothing; the edge then costs its length at the mean rate of all.
//! Cost: O(n log n).

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::charts::paths::Paths;
use crate::charts::surface::Surface;
use crate::mesh::collapse::fan;
use crate::mesh::view::{MeshView, NONE, next, prev};

/// Scratch bytes for [`proxy_costs`].
pub const fn proxy_costs_need(vertices: usize, coarse_vertices: usize) -> usize {
    (2 * bytes_for::<f64>(vertices))
        .saturating_add(4 * bytes_for::<u32>(vertices))
        .saturating_add(bytes_for::<u32>(coarse_vertices))
}

/// Fills `cost` (one entry a corner of `coarse`, whose adjacency is `twin`). `vertex` tells which vertex of `fine` each
/// coarse one is. Infinite where every way is.
pub fn proxy_costs(
    cost: &mut [f64],
    coarse: MeshView,
    twin: &[u32],
    vertex: &[u32],
    fine: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = fine.mesh.positions.len();
    scratch.require(proxy_costs_need(n, vertex.len()))?;
    let corner = scratch.take_filled::<u32>(vertex.len(), NONE)?;
    for c in 0..coarse.corner_count() as u32 {
        let at = &mut corner[coarse.vertex(c) as usize];
        if *at == NONE || twin[c as usize] == NONE {
            *at = c;
        }
    }
    let cell = scratch.take_filled::<u32>(n, NONE)?; // coarse vertex
    for (k, v) in vertex.iter().enumerate() {
        cell[*v as usize] = k as u32;
    }
    let mut paths = Paths::new(n, &mut scratch)?;
    let weight = |c: u32| fine.cost[c as usize];
    paths.grow(fine, vertex.iter().copied(), weight, |v, reached| {
        let via = reached.via[v as usize];
        if via != NONE {
            let (a, b) = (fine.mesh.vertex(via), fine.mesh.vertex(next(via)));
            cell[v as usize] = cell[(if a == v { b } else { a }) as usize];
        }
    });
    cost.fill(f64::NAN);
    for c in 0..fine.mesh.corner_count() as u32 {
        let (v, w) = (fine.mesh.vertex(c), fine.mesh.vertex(next(c)));
        let (a, b) = (cell[v as usize], cell[w as usize]);
        if a == b || a == NONE || b == NONE {
            continue;
        }
        // The half-edge from a to b, or the one from b to a where that has none.
        let leaves = fan(twin, corner[a as usize]).find_map(|d| {
            let out = coarse.vertex(next(d)) == b;
            let into = coarse.vertex(prev(d)) == b;
            if out { Some(d) } else { into.then_some(prev(d)) }
        });
        if let Some(d) = leaves {
            let sum = paths.cost[v as usize] + fine.cost[c as usize] + paths.cost[w as usize];
            for d in [d, twin[d as usize]].into_iter().filter(|d| *d != NONE) {
                // NaN: the first.
                cost[d as usize] = cost[d as usize].min(sum);
            }
        }
    }
    fill_gaps(cost, coarse);
    Ok(())
}

/// Gives the edges without a cost their length at the mean rate.
fn fill_gaps(cost: &mut [f64], coarse: MeshView) {
    let length = |c: u32| {
        let d = coarse.position(next(c)) - coarse.position(c);
        sqrt(d.dot(d))
    };
    let (mut sum, mut total) = (0.0, 0.0);
    for (c, cost) in cost.iter().enumerate().filter(|(_, cost)| cost.is_finite()) {
        sum += cost;
        total += length(c as u32);
    }
    let rate = if total > 0.0 { sum / total } else { 1.0 };
    for (c, cost) in cost.iter_mut().enumerate().filter(|(_, cost)| cost.is_nan()) {
        *cost = rate * length(c as u32);
    }
}
