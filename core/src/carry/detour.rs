//! Cuts that were carried over onto edges that must not be cut go round them.
//!
//! The diagonal of a quad that is cut is replaced by two of its sides: the face on one side of it changes sides. That is a
//! homotopy where no other cut comes to the corner that the way now touches, or leaves; such a corner is chosen where there is one.
//! Limit: where other cuts come to both, charts may join or part, which the caller looks after.

use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next, prev};

/// Rounds over all cuts: the sides of a polygon's triangle may be diagonals as well.
const ROUNDS: usize = 8;

/// Takes cuts off edges of infinite cost; whether none is left on them.
pub fn go_round(cut: &mut [u8], surface: &Surface) -> bool {
    for _ in 0..ROUNDS {
        let mut left = 0;
        for c in 0..cut.len() as u32 {
            if !is_forbidden(cut, surface, c) {
                continue;
            }
            left += 1;
            let ways = [c, surface.twin[c as usize]].map(|side| (way(cut, surface, side), side));
            let (_, side) = if ways[1].0 < ways[0].0 { ways[1] } else { ways[0] };
            for edge in [side, next(side), prev(side)] {
                let was = cut[edge as usize] != 0;
                if surface.twin[edge as usize] != NONE {
                    surface.set_cut(cut, edge, !was);
                }
            }
        }
        if left == 0 {
            return true;
        }
    }
    (0..cut.len() as u32).all(|c| !is_forbidden(cut, surface, c))
}

/// Whether the edge of `c`, the lower of its two half-edges, is cut although its cost is infinite.
pub(super) fn is_forbidden(cut: &[u8], surface: &Surface, c: u32) -> bool {
    let t = surface.twin[c as usize];
    cut[c as usize] != 0 && t != NONE && c < t && surface.cost[c as usize] == f64::INFINITY
}

/// How bad it is to go round the face of `side`: sides that must not be cut, whether other cuts are in the way, and the cost.
fn way(cut: &[u8], surface: &Surface, side: u32) -> (usize, usize, u64) {
    let sides = [next(side), prev(side)];
    let is_cut = |c: u32| cut[c as usize] != 0 || surface.twin[c as usize] == NONE;
    let forbidden = sides.iter().filter(|c| !is_cut(**c) && surface.cost[**c as usize] == f64::INFINITY).count();
    let cuts_at = |v: u32| surface.edges_at(v).filter(|(c, _)| is_cut(*c)).count();
    let apex = surface.mesh.vertex(prev(side));
    let blocked = match sides.map(is_cut) {
        [false, false] => cuts_at(apex),
        // The way turns off the corner where both cuts met.
        [true, false] => cuts_at(surface.mesh.vertex(next(side))) - 2,
        [false, true] => cuts_at(surface.mesh.vertex(side)) - 2,
        [true, true] => 2,
    };
    let open = sides.iter().filter(|c| surface.twin[**c as usize] == NONE).count();
    let cost: f64 = sides.iter().filter(|c| !is_cut(**c)).map(|c| surface.cost[*c as usize].min(1e300)).sum();
    (forbidden, blocked + open, cost.to_bits())
}
