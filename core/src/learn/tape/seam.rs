//! Seam scores: how far a vertex's neighbours fly apart in UV.
//!
//! The reach of a vertex is the smooth maximum of its distances to its neighbours in UV, shifted by the largest before
//! exponentials; a sigmoid about a tenth of the map's extent makes it a score.

use super::normalise::ends_of;
use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{NONE, Table, Var};
use crate::base::real::{exp, ln, sqrt};
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Neighbours of a vertex at the most.
pub const NEIGHBOURS: usize = 5;
/// Sharpness of the smooth maximum.
pub const GAMMA: f64 = 50.0;
/// Sharpness of the score.
pub const BETA: f64 = 50.0;
/// Reach at which the score is a half, in units of the longer side of the map's box.
pub const THRESHOLD: f64 = 0.1;

/// Y (s, 1) = (1/gamma) ln sum over j of exp(gamma |x_i - x_j|), for rows i < s of X (n, 2) and the rows j that `ring`
/// names (5 a row, NONE where there are fewer). A row without neighbours has the reach 0.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    x: Var,
    ring: Table,
    y: Var,
}

/// Y (s, 1) = sigmoid(beta (R - tau)), tau = a tenth of the longer side of the box of X; no gradient through tau.
#[derive(Clone, Copy, Debug)]
pub struct Seam {
    reach: Var,
    x: Var,
    y: Var,
}

impl<O: Operation + Copy + From<Reach> + From<Seam>> Recording<O> {
    /// Reach of the first `ring` rows of `x`; see [`Reach`].
    pub fn reach(&mut self, x: Var, ring: Table) -> Var {
        debug_assert!(x.columns == 2 && ring.len.is_multiple_of(NEIGHBOURS) && ring.len / NEIGHBOURS <= x.rows);
        let y = self.output(ring.len / NEIGHBOURS, 1, &[x]);
        self.push(Reach { x, ring, y })
    }

    /// Score of each reach in the map `x`; see [`Seam`].
    pub fn seam(&mut self, reach: Var, x: Var) -> Var {
        debug_assert!(x.columns == 2);
        let y = self.output(reach.rows, 1, &[reach]);
        self.push(Seam { reach, x, y })
    }
}

/// Distances to the neighbours, their largest, and the sum of exp(gamma (distance - largest)).
fn distances<T: Float>(x: &[T], i: usize, ring: &[u32]) -> ([T; NEIGHBOURS], T, T) {
    let mut lengths = [T::ZERO; NEIGHBOURS];
    let mut largest = T::ZERO;
    for (length, &j) in lengths.iter_mut().zip(ring).filter(|(_, j)| **j != NONE) {
        let (u, v) = (x[2 * i] - x[2 * j as usize], x[2 * i + 1] - x[2 * j as usize + 1]);
        *length = sqrt(u * u + v * v);
        if *length > largest {
            largest = *length;
        }
    }
    let there = lengths.iter().zip(ring).filter(|(_, j)| **j != NONE);
    let sum = there.fold(T::ZERO, |sum, (length, _)| sum + exp(T::of(GAMMA) * (*length - largest)));
    (lengths, largest, sum)
}

impl Operation for Reach {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let x = self.x.of(before);
        for (i, (y, ring)) in y.iter_mut().zip(self.ring.of(run.indices).as_chunks::<NEIGHBOURS>().0.iter()).enumerate()
        {
            let (_, largest, sum) = distances(x, i, ring);
            *y = if sum > T::ZERO { largest + ln(sum) / T::of(GAMMA) } else { T::ZERO };
        }
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let (x, d_x) = (self.x.of(run.values), self.x.of_mut(before));
        for (i, (d, ring)) in d_y.iter().zip(self.ring.of(run.indices).as_chunks::<NEIGHBOURS>().0.iter()).enumerate() {
            let (lengths, largest, sum) = distances(x, i, ring);
            // A score far from a half passes no gradient worth five exponentials.
            if *d == T::ZERO {
                continue;
            }
            for (length, &j) in lengths.into_iter().zip(ring) {
                if j == NONE || length <= T::ZERO {
                    continue;
                }
                let pull = *d * exp(T::of(GAMMA) * (length - largest)) / (sum * length);
                for c in 0..2 {
                    let along = pull * (x[2 * i + c] - x[2 * j as usize + c]);
                    d_x[2 * i + c] += along;
                    d_x[2 * j as usize + c] += -along;
                }
            }
        }
        Ok(())
    }
}

impl Operation for Seam {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.reach), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let x = self.x.of(before);
        let side = |c| {
            let (low, high) = ends_of(x, 2, c);
            x[2 * high + c] - x[2 * low + c]
        };
        let (u, v) = if x.is_empty() { (T::ZERO, T::ZERO) } else { (side(0), side(1)) };
        let threshold = T::of(THRESHOLD) * if u > v { u } else { v };
        let scores = y.iter_mut().zip(self.reach.of(before));
        scores.for_each(|(y, r)| *y = T::ONE / (T::ONE + exp(T::of(BETA) * (threshold - *r))));
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let scores = self.y.of(run.values).iter().zip(&*d_y);
        let d_reach = self.reach.of_mut(before).iter_mut();
        d_reach.zip(scores).for_each(|(d, (s, d_y))| *d += *d_y * T::of(BETA) * *s * (T::ONE - *s));
        Ok(())
    }
}
