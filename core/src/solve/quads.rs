//! Relaxing quads: the energy is the mean over both ways to part a quad into triangles.
//!
//! A map sees the two triangles on one diagonal only: it may bend a quad that is convex in space inwards at the ends of that
//! diagonal, and what others draw by the other diagonal folds. The two triangles there therefore bear half of the weight; they add
//! one edge to the graph, between the corners that no triangle joins. A quad that is not convex at the start is opened (`convex`).
//! Guarantee: a quad that is convex at the start stays so, as no triangle is turned over; nothing changes where there are no quads.
//! Limit: a quad that cannot be opened is relaxed by its own triangles alone. Two that share three corners are never both convex.

use super::convex::open_quads;
use super::energy::Rest;
use super::piece::{Piece, Stop};
use super::quad::Quad;
use super::relax::{Relaxation, relax};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use glam::DVec2;

/// Share of a quad's weight that the triangles on its other diagonal bear. On 19 control meshes of 320 triangles the energy over 4 is
/// 1.0168 on the own diagonals and 1.0567 on the others with 0, 1.0161 and 1.0281 with 0.1, 1.0173 and 1.0215 with 0.5.
const SHARE: f64 = 0.5;

/// Scratch bytes that [`relax_quads`] uses beyond those of [`relax`].
pub const fn quads_need(triangles: usize) -> usize {
    bytes_for::<[u32; 3]>(2 * triangles) + bytes_for::<Rest>(2 * triangles)
}

/// As [`relax`], with `quads` among the triangles of the piece.
pub fn relax_quads(
    x: &mut [DVec2],
    piece: &Piece,
    quads: &[Quad],
    stop: Stop,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Relaxation, ScratchTooSmall> {
    if quads.is_empty() || stop.steps == 0 {
        return relax(x, piece, stop, scratch, workers);
    }
    open_quads(x, piece, quads, scratch.frame())?;
    let count = quads.iter().filter(|q| q.is_convex(x)).count();
    let own = piece.triangles.len();
    let triangles = scratch.take::<[u32; 3]>(own + 2 * count)?;
    let rest = scratch.take::<Rest>(own + 2 * count)?;
    triangles[..own].copy_from(piece.triangles);
    rest[..own].copy_from(piece.rest);
    let convex = quads.iter().filter(|q| q.is_convex(x));
    for (k, quad) in (0..).zip(convex) {
        let [p, q] = quad.halves.map(|t| t as usize);
        let weight = SHARE * (rest[p].weight + rest[q].weight);
        let area: f64 = quad.rest.iter().map(|r| r.area).sum();
        for (i, (nodes, shape)) in quad.across().into_iter().zip(quad.rest).enumerate() {
            triangles[own + 2 * k + i] = nodes;
            // The area is counted already.
            rest[own + 2 * k + i] = shape;
            rest[own + 2 * k + i].weight = weight * shape.area / area;
            rest[own + 2 * k + i].area = 0.0;
        }
        rest[p].weight *= 1.0 - SHARE;
        rest[q].weight *= 1.0 - SHARE;
    }
    relax(x, &Piece { triangles, rest, ..*piece }, stop, scratch, workers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::solve::piece::Spring;
    use glam::DVec3;
    use std::vec;

    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
    const STOP: Stop = Stop { steps: 60, tolerance: 1e-9 };

    /// A unit square whose first corner a spring pulls to the third, the others held, relaxed with these quads and so much memory.
    fn pulled(quads: &[Quad], bytes: usize) -> Result<[DVec2; 4], ScratchTooSmall> {
        let at = square();
        let rest = TRIANGLES.map(|t| Rest::new(t.map(|i| at[i as usize]), 0.0));
        let springs = [Spring { a: 0, b: 2, weight: 1e3 }];
        let piece = Piece { triangles: &TRIANGLES, rest: &rest, free: 1, at: &at, springs: &springs, walls: &[] };
        let mut x = at.map(|p| p.truncate());
        let mut memory = vec![0; bytes];
        relax_quads(&mut x, &piece, quads, STOP, Scratch::new(&mut memory), &Serial)?;
        Ok(x)
    }

    fn square() -> [DVec3; 4] {
        [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]
    }

    #[test]
    fn a_quad_that_is_pulled_inwards_stays_convex() {
        let quad = Quad::new([0, 1], [0, 1, 2, 3], square()).expect("a square is convex");
        let bytes = 1 << 20;
        // Its triangles alone let that corner come past the middle.
        assert!(!quad.is_convex(&pulled(&[], bytes).unwrap()));
        let x = pulled(&[quad], bytes).unwrap();
        assert!(quad.is_convex(&x) && x != pulled(&[], bytes).unwrap());
        assert!(pulled(&[quad], 400).is_err());
    }

    #[test]
    fn a_square_in_place_does_not_move() {
        let (at, quad) = (square(), Quad::new([0, 1], [0, 1, 2, 3], square()).unwrap());
        let rest = TRIANGLES.map(|t| Rest::new(t.map(|i| at[i as usize]), 0.0));
        let piece = Piece { triangles: &TRIANGLES, rest: &rest, free: 4, at: &at, springs: &[], walls: &[] };
        let mut x = at.map(|p| p.truncate());
        let mut memory = vec![0; 1 << 20];
        let done = relax_quads(&mut x, &piece, &[quad], STOP, Scratch::new(&mut memory), &Serial).unwrap();
        // Both ways together weigh as much as one: 4 times the area.
        assert!((done.after - 4.0).abs() < 1e-6, "{}", done.after);
        assert!(x.iter().zip(at).all(|(x, p)| x.distance(p.truncate()) < 1e-6));
    }

    #[test]
    fn only_what_is_convex_and_nearly_flat_is_a_quad() {
        let quad = |third: DVec3| {
            let [a, b, _, d] = square();
            Quad::new([0, 1], [0, 1, 2, 3], [a, b, third, d])
        };
        assert!(quad(DVec3::new(1.0, 1.0, 0.2)).is_some());
        assert!(quad(DVec3::new(0.4, 0.4, 0.0)).is_none(), "bent inwards");
        assert!(quad(DVec3::new(0.5, 0.5, 0.0)).is_none(), "straight at a corner");
        assert!(quad(DVec3::NAN).is_none());
    }
}
