//! A strip: a chart whose border turns at four corners and nowhere inwards. Its rectangle.
//!
//! The border is laid on a rectangle by arc length, inner nodes at the balance of springs (Tutte 1963) and then at least energy; the
//! rectangle's sides are those of least energy, in closed form: with a, b the weighted squares of the rows of the Jacobians and
//! c, d those of the columns of their inverses, x is best stretched by (c / a)^1/4 and y by (d / b)^1/4.
//! Guarantee: no triangle is turned over where the answer is yes. Limit: where the two long sides of a strip are matched otherwise than by
//! arc length, a rectangle with less energy exists.

use crate::base::real::{atan2, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::solve::flatten::balance;
use crate::solve::piece::{Piece, Stop};
use crate::solve::relax::relax;
use core::f64::consts::PI;
use glam::DVec2;

/// Turn of the border, in degrees, from which on a node is a corner, and up to which it is one of a rectangle.
pub(super) const CORNER: [f64; 2] = [45.0, 135.0];
/// Turn inwards from which on a border is no side of a strip.
const INWARDS: f64 = -30.0;
/// Times that the sides and the inside are brought to least energy in turn: the sides then move by less than 1e-4.
const ROUNDS: usize = 3;

/// Places of the four corners in a border that goes once round a chart counter-clockwise; none where it is no strip.
pub fn corners(border: &[DVec2]) -> Option<[usize; 4]> {
    let mut found = heapless::Vec::<usize, 4>::new();
    let mut before = border.last().zip(border.first()).map(|(a, b)| *b - *a)?;
    for (i, p) in border.iter().enumerate() {
        let side = border[wrapped(i + 1, border.len())] - *p;
        let turn = atan2(before.perp_dot(side), before.dot(side)) * 180.0 / PI;
        if !(INWARDS..=CORNER[1]).contains(&turn) {
            return None;
        }
        if turn >= CORNER[0] {
            found.push(i).ok()?;
        }
        before = side;
    }
    found.into_array().ok()
}

/// How far a side of the border is from straight at the most, over its length.
pub fn bend(border: &[DVec2], corners: [usize; 4]) -> f64 {
    let sides = (0..4).map(|k| (corners[k], corners[(k + 1) % 4]));
    let of_side = |(from, to): (usize, usize)| {
        let (a, chord) = (border[from], border[to] - border[from]);
        let steps = wrapped(to + border.len() - from, border.len());
        let away =
            (1..steps).map(|i| chord.perp_dot(border[wrapped(from + i, border.len())] - a).abs()).fold(0.0, f64::max);
        away / chord.length_squared().max(f64::MIN_POSITIVE)
    };
    sides.map(of_side).fold(0.0, f64::max)
}

/// Lays a strip on a rectangle; its border nodes are `inner..`, in the order of the edges of `border`. Answers whether there is
/// one; where not, `x` is as it was or has turned triangles.
pub fn lay(
    x: &mut [DVec2],
    piece: &Piece,
    inner: usize,
    border: &[[u32; 2]],
    stop: Stop,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    let count = border.len();
    if inner + count != x.len() {
        return Ok(false);
    }
    {
        let mut frame = scratch.frame();
        let points = frame.take::<DVec2>(count)?;
        points.iter_mut().zip(border).for_each(|(p, e)| *p = x[e[0] as usize]);
        let Some(corners) = corners(points) else { return Ok(false) };
        place(x, piece, border, corners);
    }
    balance(x, piece, inner, scratch.frame(), workers)?;
    for round in 0..=ROUNDS {
        let Some(scale) = best_scale(x, piece) else { return Ok(false) };
        x.iter_mut().for_each(|p| *p *= scale);
        if round < ROUNDS && inner > 0 {
            relax(x, &Piece { free: inner, ..*piece }, stop, scratch.frame(), workers)?;
        }
    }
    Ok(true)
}

/// Puts the border on a rectangle whose sides are as long as those of the strip are on the mean.
fn place(x: &mut [DVec2], piece: &Piece, border: &[[u32; 2]], corners: [usize; 4]) {
    let count = border.len();
    let length = |i: usize| {
        let [a, b] = border[wrapped(i, count)].map(|n| piece.at[n as usize]);
        sqrt((b - a).dot(b - a))
    };
    let steps = |k: usize| wrapped(corners[(k + 1) % 4] + count - corners[k], count);
    let side = |k: usize| (0..steps(k)).map(|i| length(corners[k] + i)).sum::<f64>();
    let lengths = [0, 1, 2, 3].map(side);
    let (wide, high) = (0.5 * (lengths[0] + lengths[2]), 0.5 * (lengths[1] + lengths[3]));
    let ends = [DVec2::ZERO, DVec2::new(wide, 0.0), DVec2::new(wide, high), DVec2::new(0.0, high)];
    for k in 0..4 {
        let mut along = 0.0;
        for i in 0..steps(k) {
            let share = along / lengths[k].max(f64::MIN_POSITIVE);
            x[border[wrapped(corners[k] + i, count)][0] as usize] = ends[k] + (ends[(k + 1) % 4] - ends[k]) * share;
            along += length(corners[k] + i);
        }
    }
}

/// Stretches along both axes of least energy; none where a triangle is turned over or flat.
fn best_scale(x: &[DVec2], piece: &Piece) -> Option<DVec2> {
    let (mut stretch, mut shrink) = (DVec2::ZERO, DVec2::ZERO);
    for (t, rest) in piece.triangles.iter().zip(piece.rest) {
        let [u, v] = rest.jacobian(t.map(|i| x[i as usize]));
        let det = u.perp_dot(v);
        if det.is_nan() || det <= 0.0 {
            return None;
        }
        stretch += DVec2::new(u.x * u.x + v.x * v.x, u.y * u.y + v.y * v.y) * rest.weight;
        // The inverse's columns: (v.y, -u.y) and (-v.x, u.x) over the determinant.
        shrink += DVec2::new(u.y * u.y + v.y * v.y, u.x * u.x + v.x * v.x) * (rest.weight / (det * det));
    }
    let fourth = |a: f64| sqrt(sqrt(a));
    let scale = DVec2::new(fourth(shrink.x / stretch.x), fourth(shrink.y / stretch.y));
    (scale.is_finite() && scale.min_element() > 0.0).then_some(scale)
}

/// A place in a cycle of `count`, from one that is less than a whole round too far.
fn wrapped(place: usize, count: usize) -> usize {
    if place < count { place } else { place - count }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::solve::energy::Rest;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    const STOP: Stop = Stop { steps: 20, tolerance: 1e-9 };

    #[test]
    fn corners_are_where_a_border_turns_and_nothing_turns_inwards() {
        let points = |p: &[[f64; 2]]| p.iter().map(|p| DVec2::from(*p)).collect::<Vec<_>>();
        let strip = points(&[[1.0, 0.0], [2.0, 0.1], [3.0, 0.0], [3.0, 1.0], [2.0, 1.1], [0.0, 1.0], [0.0, 0.0]]);
        assert_eq!(corners(&strip), Some([2, 3, 5, 6]));
        assert_abs_diff_eq!(bend(&strip, [2, 3, 5, 6]), 0.1 / 3.0, epsilon = 1e-12);
        // A notch, a triangle, two points, nothing.
        assert_eq!(corners(&points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.4], [0.0, 1.0]])), None);
        assert_eq!(corners(&strip[..3]), None);
        assert_eq!((corners(&strip[..2]), corners(&[])), (None, None));
    }

    /// A part of a flat ring with radii 4 and 5. The mean of ln(r / 4.5)^2 over the bases of its triangles is .0051; their shear adds to it.
    #[test]
    fn a_bent_strip_becomes_a_rectangle_of_least_energy() {
        let (columns, rows) = (24, 3);
        let at: Vec<DVec3> = (0..=columns)
            .flat_map(|i| (0..=rows).map(move |j| (i, j)))
            .map(|(i, j)| {
                let radius = 4.0 + f64::from(j) / f64::from(rows);
                (DVec2::from_angle(1.5 * f64::from(i) / f64::from(columns)) * radius).extend(0.0)
            })
            .collect();
        let id = |i: u32, j: u32| i * (rows as u32 + 1) + j;
        let cells = (0..columns as u32).flat_map(|i| (0..rows as u32).map(move |j| (i, j)));
        let faces: Vec<[u32; 3]> = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        // Inner nodes first.
        let (last, top) = (columns as u32, rows as u32);
        let mut round: Vec<u32> = (0..top).map(|j| id(0, j)).collect();
        round.extend((0..last).map(|i| id(i, top)).chain((1..=top).rev().map(|j| id(last, j))));
        round.extend((1..=last).rev().map(|i| id(i, 0)));
        let mut order: Vec<u32> = (0..at.len() as u32).filter(|n| !round.contains(n)).collect();
        let inner = order.len();
        order.extend(&round);
        let place_of = |n: u32| order.iter().position(|o| *o == n).unwrap() as u32;
        let triangles: Vec<[u32; 3]> = faces.iter().map(|f| f.map(place_of)).collect();
        let at: Vec<DVec3> = order.iter().map(|n| at[*n as usize]).collect();
        let count = round.len() as u32;
        let border: Vec<[u32; 2]> = (0..count).map(|i| [inner as u32 + i, inner as u32 + (i + 1) % count]).collect();
        let mut x: Vec<DVec2> = at.iter().map(|p| p.truncate()).collect();
        let area = |x: &[DVec2], t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| x[i as usize]);
            (b - a).perp_dot(c - a)
        };
        let turned = triangles.iter().filter(|t| area(&x, t) <= 0.0).count();
        assert_eq!(turned, 0);
        let rest: Vec<Rest> = triangles.iter().map(|t| Rest::new(t.map(|i| at[i as usize]), 0.0)).collect();
        let piece = Piece { triangles: &triangles, rest: &rest, free: at.len(), at: &at, springs: &[], walls: &[] };
        let mut bytes = vec![0; 1 << 22];
        assert!(lay(&mut x, &piece, inner, &border, STOP, Scratch::new(&mut bytes), &Serial).unwrap());
        let ring: Vec<DVec2> = border.iter().map(|e| x[e[0] as usize]).collect();
        let four = corners(&ring).unwrap();
        assert!(bend(&ring, four) < 1e-12);
        let mean = triangles.iter().zip(&rest).map(|(t, r)| r.weight * r.energy(t.map(|i| x[i as usize]))).sum::<f64>()
            / rest.iter().map(|r| r.weight).sum::<f64>()
            / 4.0;
        assert!((1.0051..1.006).contains(&mean), "{mean}");
    }
}
