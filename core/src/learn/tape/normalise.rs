//! norm(q) = (q - centre of the box) / largest distance from that centre.
//!
//! Gradients flow through the two ends of the box along each axis and through the farthest row; the first of equals
//! counts. Where all rows coincide (or one is not finite) the result is zero and no gradient flows.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{Table, Var};
use crate::base::real::sqrt;
use crate::base::scratch::ScratchTooSmall;
use crate::base::slices::Slices;
use crate::learn::kernels::float::Float;

/// Y (n, 2) = norm(X).
#[derive(Clone, Copy, Debug)]
pub struct Normalise {
    x: Var,
    y: Var,
    ends: Table, // rows: lowest and highest of each column, then the farthest
}

impl<O: Operation + Copy + From<Normalise>> Recording<O> {
    /// Rows of two columns moved to the centre and scaled into the unit disk.
    pub fn normalise(&mut self, x: Var) -> Var {
        debug_assert_eq!(x.columns, 2, "points of the plane");
        let ends = self.table(5);
        let y = self.output(x.rows, 2, &[x]);
        self.push(Normalise { x, y, ends })
    }
}

/// Rows that hold the lowest and highest value of column `c`, the first of equals.
pub(super) fn ends_of<T: Float>(x: &[T], columns: usize, c: usize) -> (usize, usize) {
    let mut ends = (0, 0);
    for (i, row) in x.rows(columns).enumerate() {
        if row[c] < x[ends.0 * columns + c] {
            ends.0 = i;
        }
        if row[c] > x[ends.1 * columns + c] {
            ends.1 = i;
        }
    }
    ends
}

/// Centre of the box whose ends are given, and 1 / radius, 0 where there is none.
fn frame<T: Float>(x: &[T], ends: &[u32]) -> ([T; 2], T) {
    let half = T::of(0.5);
    let centre: [T; 2] =
        core::array::from_fn(|c| (x[ends[2 * c] as usize * 2 + c] + x[ends[2 * c + 1] as usize * 2 + c]) * half);
    let radius = sqrt(distance(x, ends[4] as usize, centre));
    (centre, if radius > T::ZERO { T::ONE / radius } else { T::ZERO })
}

fn distance<T: Float>(x: &[T], i: usize, centre: [T; 2]) -> T {
    let (u, v) = (x[2 * i] - centre[0], x[2 * i + 1] - centre[1]);
    u * u + v * v
}

impl Operation for Normalise {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let x = self.x.of(before);
        if x.is_empty() {
            return Ok(());
        }
        let ends = self.ends.of_mut(run.indices);
        for c in 0..2 {
            let (low, high) = ends_of(x, 2, c);
            (ends[2 * c], ends[2 * c + 1]) = (low as u32, high as u32);
        }
        let (centre, _) = frame(x, ends);
        let mut far = 0;
        for i in 1..self.x.rows {
            if distance(x, i, centre) > distance(x, far, centre) {
                far = i;
            }
        }
        ends[4] = far as u32;
        let (centre, scale) = frame(x, ends);
        for (i, y) in y.iter_mut().enumerate() {
            *y = (x[i] - centre[i % 2]) * scale;
        }
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let d_x = self.x.of_mut(before);
        if d_x.is_empty() {
            return Ok(());
        }
        let (x, y, ends) = (self.x.of(run.values), self.y.of(run.values), self.ends.of(run.indices));
        let (_, scale) = frame(x, ends);
        let (mut d_centre, mut d_radius) = ([0.0; 2], 0.0);
        for (i, d) in d_y.iter().enumerate() {
            d_x[i] += *d * scale;
            d_centre[i % 2] -= (*d * scale).wide();
            d_radius -= (*d * y[i] * scale).wide();
        }
        let far = ends[4] as usize;
        for c in 0..2 {
            let pull = d_radius * y[2 * far + c].wide();
            d_x[2 * far + c] += T::of(pull);
            let half = T::of((d_centre[c] - pull) * 0.5);
            d_x[2 * ends[2 * c] as usize + c] += half;
            d_x[2 * ends[2 * c + 1] as usize + c] += half;
        }
        Ok(())
    }
}
