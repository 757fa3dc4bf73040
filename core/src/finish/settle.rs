//! Each chart in a frame of its own: its mean at the origin, its longest straight border or else its first far corner along the x axis.
//!
//! A map has no energy in moving and turning, so Newton's method leaves both to rounding, amplified by what holds them in the
//! system (`relax`): charts of the same mesh in two places differ by 1e-7 of a turn, and packing by 2 % of the square. In its
//! own frame (as `mesh::frame` for a whole mesh) a chart is the same wherever it came from.
//! Guarantee: rigid motions alone. Cost: O(n), four values a chart.

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use glam::DVec2;

/// Share of the largest distance from the mean from which on a corner is far; no ratio that regular shapes have.
const FAR: f64 = 0.618;

/// Moves and turns the charts. `uv` stands at corners, `chart` (below `count`) at faces; `along` has a chart's straight direction, or
/// zero.
pub fn settle(
    uv: &mut [DVec2],
    chart: &[u32],
    along: &[DVec2], // (count)
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let count = along.len();
    let mean = scratch.take::<DVec2>(count)?;
    let corners = scratch.take::<f64>(count)?;
    let farthest = scratch.take::<f64>(count)?;
    let axis = scratch.take::<DVec2>(count)?;
    axis.copy_from(along);
    let of = |c: usize| chart[c / 3] as usize;
    for (c, p) in uv.iter().enumerate() {
        mean[of(c)] += *p;
        corners[of(c)] += 1.0;
    }
    mean.iter_mut().zip(corners.iter()).for_each(|(m, n)| *m /= n.max(1.0));
    for (c, p) in uv.iter_mut().enumerate() {
        *p -= mean[of(c)];
        farthest[of(c)] = farthest[of(c)].max(p.dot(*p));
    }
    for (c, p) in uv.iter().enumerate() {
        if axis[of(c)] == DVec2::ZERO && p.dot(*p) >= FAR * FAR * farthest[of(c)] {
            axis[of(c)] = *p;
        }
    }
    for (c, p) in uv.iter_mut().enumerate() {
        let length = sqrt(axis[of(c)].dot(axis[of(c)]));
        if length > 0.0 {
            let x = axis[of(c)] / length;
            *p = DVec2::new(x.dot(*p), x.perp_dot(*p));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn settled(uv: &[DVec2], chart: &[u32]) -> Vec<DVec2> {
        let mut out = uv.to_vec();
        let mut bytes = vec![0u8; 4096];
        settle(&mut out, chart, &[DVec2::ZERO; 2], Scratch::new(&mut bytes)).unwrap();
        out
    }

    #[test]
    fn charts_that_differ_by_a_rigid_motion_settle_alike() {
        let shape = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let turn = DVec2::new(0.6, 0.8);
        let moved = shape.map(|p| turn.rotate(p) + DVec2::new(5.0, -7.0));
        let out = settled(&[shape, moved].concat(), &[0, 1]);
        // A few roundings of numbers below 10.
        assert!((0..3).all(|i| out[i].abs_diff_eq(out[i + 3], 1e-14)), "{out:?}");
        assert!((out[0].y).abs() < 1e-15 && (out[1] - out[0]).length() - 3.0 < 1e-14);
        assert!((out[1] - out[0]).perp_dot(out[2] - out[0]) > 2.99);
    }

    #[test]
    fn a_chart_in_one_point_stays_and_too_little_memory_is_refused() {
        assert_eq!(settled(&[DVec2::ONE; 3], &[1]), [DVec2::ZERO; 3]);
        let mut uv = [DVec2::ONE; 3];
        assert!(settle(&mut uv, &[0], &[DVec2::ZERO], Scratch::new(&mut [0; 47])).is_err());
        assert_eq!(uv, [DVec2::ONE; 3]);
    }
}
