//! Quads that are convex in space and not in a map are opened there: their corners are moved until they are convex.
//!
//! A quad fails where one of the two triangles on its other diagonal is turned over. Each corner of that triangle alone, or all three,
//! moves along the gradient of its area to a small share of its area in space; of the moves that turn over no triangle of the piece and
//! leave fewer quads failing, that of least energy is taken.
//! Guarantee: no triangle is turned over, no more quads fail than before. Limit: a quad is left where no such move is. Cost: O(n)
//! where a quad fails, else a look at the quads.

use super::piece::Piece;
use super::quad::Quad;
use crate::base::buckets::Buckets;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use glam::DVec2;

/// Times that all quads are looked at: one that is opened makes room for its neighbours.
const ROUNDS: usize = 3;
/// Shares of its area in space that a triangle which is turned over gets.
const SHARES: [f64; 3] = [0.2, 0.05, 0.01];
/// Which corners of it move.
const MOVES: [[bool; 3]; 4] = [[true, false, false], [false, true, false], [false, false, true], [true; 3]];

/// Opens what it can of `quads` at `x`; the others stay as they are.
pub fn open_quads(x: &mut [DVec2], piece: &Piece, quads: &[Quad], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    if quads.iter().all(|q| q.is_convex(x)) {
        return Ok(());
    }
    let sides = 3 * piece.triangles.len();
    let triangle_at = |i: u32| Some(piece.triangles[i as usize / 3][i as usize % 3]);
    let quad_at = |i: u32| Some(quads[i as usize / 4].nodes[i as usize % 4]);
    let around = Incidence {
        piece,
        quads,
        triangles: Buckets::new(x.len(), sides, triangle_at, &mut scratch)?,
        of_quads: Buckets::new(x.len(), 4 * quads.len(), quad_at, &mut scratch)?,
    };
    for _ in 0..ROUNDS {
        let mut opened = false;
        for quad in quads {
            for failing in quad.failing(x).into_iter().flatten() {
                opened |= around.open(x, failing);
            }
        }
        if !opened {
            break;
        }
    }
    Ok(())
}

/// What is around each node.
struct Incidence<'r> {
    piece: &'r Piece<'r>,
    quads: &'r [Quad],
    triangles: Buckets<'r>,
    of_quads: Buckets<'r>,
}

impl Incidence<'_> {
    /// Moves the corners of a triangle on the other diagonal of a quad so that it is upright; whether that could be.
    fn open(&self, x: &mut [DVec2], (nodes, area): ([u32; 3], f64)) -> bool {
        let at = nodes.map(|n| x[n as usize]);
        let now = (at[1] - at[0]).perp_dot(at[2] - at[0]);
        let slope = [at[2] - at[1], at[0] - at[2], at[1] - at[0]].map(|side| side.perp());
        let before = self.failing(x, nodes);
        let mut best: Option<(f64, [DVec2; 3])> = None;
        for (moves, share) in MOVES.iter().flat_map(|m| SHARES.map(|s| (m, s))) {
            let is_free = |i: usize| (nodes[i] as usize) < self.piece.free;
            let moves = [0, 1, 2].map(|i| if moves[i] && is_free(i) { slope[i] } else { DVec2::ZERO });
            let steep: f64 = moves.iter().map(|m| m.dot(*m)).sum();
            let length = (2.0 * share * area - now) / steep.max(f64::MIN_POSITIVE);
            let to = [0, 1, 2].map(|i| at[i] + moves[i] * length);
            (0..3).for_each(|i| x[nodes[i] as usize] = to[i]);
            let energy = self.energy(x, nodes);
            if energy < best.map_or(f64::INFINITY, |(least, _)| least) && self.failing(x, nodes) < before {
                best = Some((energy, to));
            }
        }
        let to = best.map_or(at, |(_, to)| to);
        (0..3).for_each(|i| x[nodes[i] as usize] = to[i]);
        to != at
    }

    /// Energy of the triangles around these nodes.
    fn energy(&self, x: &[DVec2], nodes: [u32; 3]) -> f64 {
        let around = nodes.iter().flat_map(|n| self.triangles.get(*n as usize)).map(|i| *i as usize / 3);
        around.map(|t| self.piece.rest[t].energy(self.piece.triangles[t].map(|i| x[i as usize]))).sum()
    }

    /// How many quads around these nodes are not convex.
    fn failing(&self, x: &[DVec2], nodes: [u32; 3]) -> usize {
        let around = nodes.iter().flat_map(|n| self.of_quads.get(*n as usize)).map(|i| *i as usize / 4);
        around.filter(|q| !self.quads[*q].is_convex(x)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::energy::Rest;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// Opens the quads with these nodes, the first and third of which are the ends of the diagonal, in space at `at`, where they lie at
    /// `x` in the map; answers how many fail then and whether a triangle is turned over.
    fn opened(nodes: &[[u32; 4]], at: &[(f64, f64)], x: &mut [DVec2], free: usize) -> (usize, bool) {
        let at: Vec<DVec3> = at.iter().map(|(x, y)| DVec3::new(*x, *y, 0.0)).collect();
        let triangles: Vec<[u32; 3]> = nodes.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let rest: Vec<Rest> = triangles.iter().map(|t| Rest::new(t.map(|i| at[i as usize]), 0.0)).collect();
        let quad = |(k, n): (u32, &[u32; 4])| Quad::new([2 * k, 2 * k + 1], *n, n.map(|i| at[i as usize]));
        let quads: Vec<Quad> = (0..).zip(nodes).map(|pair| quad(pair).expect("convex in space")).collect();
        let piece = Piece { triangles: &triangles, rest: &rest, free, at: &at, springs: &[], walls: &[] };
        let mut memory = vec![0; 1 << 16];
        open_quads(x, &piece, &quads, Scratch::new(&mut memory)).unwrap();
        let turned = triangles.iter().zip(&rest).any(|(t, r)| !r.energy(t.map(|i| x[i as usize])).is_finite());
        (quads.iter().filter(|q| !q.is_convex(x)).count(), turned)
    }

    const SQUARE: [(f64, f64); 4] = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];

    fn bent() -> [DVec2; 4] {
        [DVec2::splat(0.6), DVec2::X, DVec2::ONE, DVec2::Y]
    }

    #[test]
    fn a_square_that_is_bent_inwards_is_opened() {
        let mut x = bent();
        assert_eq!(opened(&[[0, 1, 2, 3]], &SQUARE, &mut x, 4), (0, false));
        assert_ne!(x, bent());
    }

    #[test]
    fn nodes_that_are_held_stay() {
        let mut x = bent();
        assert_eq!(opened(&[[0, 1, 2, 3]], &SQUARE, &mut x, 0), (1, false));
        assert_eq!(x, bent());
        // With one that may move it is that one.
        assert_eq!(opened(&[[0, 1, 2, 3]], &SQUARE, &mut x, 1), (0, false));
        assert_eq!(x[1..], bent()[1..]);
    }

    #[test]
    fn what_is_convex_stays_as_it_is() {
        let mut x = SQUARE.map(|(x, y)| DVec2::new(2.0 * x, y));
        let before = x;
        assert_eq!(opened(&[[0, 1, 2, 3]], &SQUARE, &mut x, 4), (0, false));
        assert_eq!(x, before);
    }

    #[test]
    fn one_is_not_opened_by_closing_its_neighbour() {
        // Two squares that share an edge; the first one is bent inwards where it meets the second.
        let at = [(0., 0.), (1., 0.), (1., 1.), (0., 1.), (2., 0.), (2., 1.)];
        let mut x = at.map(|(x, y)| DVec2::new(x, y));
        x[2] = DVec2::new(0.4, 0.4);
        let (failing, turned) = opened(&[[0, 1, 2, 3], [1, 4, 5, 2]], &at, &mut x, 6);
        assert_eq!((failing, turned), (0, false));
    }
}
