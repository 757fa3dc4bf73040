//! 1 - the mean cosine between rows and given directions, each row's own or that of its nearest point.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{NONE, Table, Var};
use crate::base::real::sqrt;
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Lengths are taken as this at the least, so that the zero vector has the cosine 0 and a finite gradient.
const SHORTEST: f64 = 1e-8;

/// Y (1, 1) = 1 - mean over rows i of cos(A_i, B_m(i)); B without gradient; m(i) = i without a table.
#[derive(Clone, Copy, Debug)]
pub struct Cosine {
    a: Var,
    b: Var,
    map: Option<Table>,
    y: Var,
}

impl<O: Operation + Copy + From<Cosine>> Recording<O> {
    /// 1 - mean cosine of the rows of `a` with those of the input `b` that `map` names (the same row without it).
    pub fn cosine(&mut self, a: Var, b: Var, map: Option<Table>) -> Var {
        debug_assert!(a.columns == 3 && b.columns == 3 && !b.has_gradient, "vectors, and fixed ones beside them");
        debug_assert!(map.map_or(a.rows <= b.rows, |map| map.len >= a.rows), "a direction for each row");
        let y = self.output(1, 1, &[a]);
        self.push(Cosine { a, b, map, y })
    }
}

impl Cosine {
    /// Of row i: the two vectors and their lengths. None where the table names no row.
    fn row<'v, T: Float>(&self, values: &'v [T], indices: &[u32], i: usize) -> Option<(&'v [T], &'v [T], T, T)> {
        let to = self.map.map_or(i as u32, |map| map.of(indices)[i]);
        if to == NONE {
            return None;
        }
        let (a, b) = (&self.a.of(values)[3 * i..][..3], &self.b.of(values)[3 * to as usize..][..3]);
        let length = |v: &[T]| sqrt(dot(v, v));
        Some((a, b, length(a), length(b)))
    }
}

pub(super) fn dot<T: Float>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

fn at_least<T: Float>(x: T) -> T {
    let least = T::of(SHORTEST);
    if x > least { x } else { least }
}

impl Operation for Cosine {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.a), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let rows = (0..self.a.rows).filter_map(|i| self.row(before, run.indices, i));
        let sum: f64 = rows.map(|(a, b, la, lb)| (dot(a, b) / (at_least(la) * at_least(lb))).wide()).sum();
        y[0] = T::of(1.0 - sum / self.a.rows.max(1) as f64);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let share = T::of(-d_y[0].wide() / self.a.rows.max(1) as f64);
        for (i, d_a) in self.a.of_mut(before).as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let Some((a, b, la, lb)) = self.row(run.values, run.indices, i) else { continue };
            let scale = share / (at_least(la) * at_least(lb));
            // The length's own derivative: none where the floor stands in for it.
            let along = if la > T::of(SHORTEST) { dot(a, b) / (la * la) } else { T::ZERO };
            (0..3).for_each(|c| d_a[c] += scale * (b[c] - along * a[c]));
        }
        Ok(())
    }
}
