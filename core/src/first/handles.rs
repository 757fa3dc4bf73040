//! Cuts through handles: tree-cotree decomposition (Eppstein 2003; Erickson, Har-Peled 2004) of the surface with its holes capped.
//!
//! A tree of cheapest paths, a dual tree over the other edges (dearest loops first), and for each edge in neither the loop that it
//! closes. Guarantee: what is left is a sphere with holes. Cost: O(n log n).

use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::charts::paths::Paths;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};

/// Cuts the loops of a tree-cotree decomposition of the capped surface and marks their vertices.
pub(super) fn cut_handles(
    cut: &mut [u8],
    joined: &mut [u8],
    loops: &[u32],
    loop_count: usize,
    component: &[u32],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = component.len();
    let faces = surface.mesh.faces.len();
    let mut paths = Paths::new(n, &mut scratch)?;
    let rooted = scratch.take::<u8>(n)?;
    let roots = (0..n as u32).filter(|v| {
        let first = &mut rooted[component[*v as usize] as usize];
        *first += u8::from(*first == 0) * 2;
        let is_first = *first == 2;
        *first = 1;
        is_first
    });
    // Border edges cost nothing: a path may follow them.
    let weight = |c: u32| if surface.twin[c as usize] == NONE { 0.0 } else { surface.cost[c as usize] };
    paths.grow(surface, roots, weight, |_, _| {});
    let in_tree = |c: u32| {
        let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
        let same = |v: u32| {
            let via = paths.via[v as usize];
            via == c || (via != NONE && via == surface.twin[c as usize])
        };
        same(a) || same(b)
    };
    let list = scratch.take::<[u64; 2]>(surface.mesh.corner_count())?;
    let mut len = 0;
    for c in 0..surface.mesh.corner_count() as u32 {
        let t = surface.twin[c as usize];
        if (t == NONE || c < t) && !in_tree(c) {
            let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
            let around = paths.cost[a as usize] + paths.cost[b as usize] + weight(c);
            // Dearest first: larger non-negative floats have larger bits.
            list[len] = [!around.max(0.0).to_bits(), u64::from(c)];
            len += 1;
        }
    }
    let list = &mut list[..len];
    sort::ascending(list);
    let parent = scratch.take::<u32>(faces + loop_count)?;
    let mut dual = UnionFind::new(parent);
    for [_, c] in list.iter() {
        let c = *c as u32;
        let t = surface.twin[c as usize];
        let other = if t == NONE { faces as u32 + loops[surface.mesh.vertex(c) as usize] } else { t / 3 };
        if dual.union(c / 3, other) || t == NONE {
            continue;
        }
        // In neither tree: the edge closes a loop around a handle.
        surface.set_cut(cut, c, true);
        for end in [surface.mesh.vertex(c), surface.mesh.vertex(next(c))] {
            for (e, _) in paths.trace(surface, end) {
                if surface.twin[e as usize] != NONE {
                    surface.set_cut(cut, e, true);
                }
            }
        }
    }
    prune(cut, surface, |_| false, scratch)?;
    for c in 0..surface.mesh.corner_count() as u32 {
        if cut[c as usize] != 0 {
            joined[surface.mesh.vertex(c) as usize] = 1;
            joined[surface.mesh.vertex(next(c)) as usize] = 1;
        }
    }
    Ok(())
}

/// Removes cut edges that end freely at a vertex which `keep` does not hold, until none is left.
fn prune(
    cut: &mut [u8],
    surface: &Surface,
    keep: impl Fn(u32) -> bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let degree = scratch.take::<u32>(n)?;
    for c in 0..surface.mesh.corner_count() as u32 {
        let t = surface.twin[c as usize];
        if t == NONE || (cut[c as usize] != 0 && c < t) {
            degree[surface.mesh.vertex(c) as usize] += 1;
            degree[surface.mesh.vertex(next(c)) as usize] += 1;
        }
    }
    for v in 0..n as u32 {
        let mut at = v;
        while degree[at as usize] == 1 && !keep(at) {
            let Some((c, w)) = surface.edges_at(at).find(|(c, _)| cut[*c as usize] != 0) else { break };
            surface.set_cut(cut, c, false);
            degree[at as usize] = 0;
            degree[w as usize] -= 1;
            at = w;
        }
    }
    Ok(())
}
