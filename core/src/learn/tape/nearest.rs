//! How well two sets of points in space cover each other, by squared distances to the nearest.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{NONE, Table, Var};
use crate::base::scratch::ScratchTooSmall;
use crate::base::workers::{Workers, for_each_chunk};
use crate::learn::kernels::float::Float;
use crate::learn::near::{Tree, distance, tree_need};

/// Queries of a task: about 0.1 ms.
const CHUNK: usize = 128;

/// Y (1, 1) = the larger of two means: of the squared distance from each row of A to the nearest of B, and from each row
/// of B to the nearest of A; B without gradient. Where the means are equal the first counts.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    a: Var,
    b: Var,
    y: Var,
    to_b: Table,  // (a rows)
    to_a: Table,  // (b rows)
    which: Table, // (1): 0 where the first mean is the larger
}

impl<O: Operation + Copy + From<Nearest>> Recording<O> {
    /// The measure, and the table of each row's nearest point of the input `b`.
    pub fn nearest(&mut self, a: Var, b: Var) -> (Var, Table) {
        debug_assert!(
            a.columns == 3 && b.columns == 3 && !b.has_gradient,
            "points in space, and fixed ones beside them"
        );
        let (to_b, to_a, which) = (self.table(a.rows), self.table(b.rows), self.table(1));
        let y = self.output(1, 1, &[a]);
        (self.push(Nearest { a, b, y, to_b, to_a, which }), to_b)
    }
}

/// Writes for each row of `from` the nearest of `to`, whose tree is given. Whatever row stands in `out` bounds the
/// search, without influence on the result: after a small step the nearest is mostly the same as before.
fn search<T: Float>(out: &mut [u32], from: &[T], to: &[T], tree: &Tree<T, 3>, workers: &dyn Workers) {
    for_each_chunk(workers, out, CHUNK, &|task, out| {
        for (out, at) in out.iter_mut().zip(from[task * CHUNK * 3..].as_chunks::<3>().0.iter()) {
            let before = to.as_chunks::<3>().0.get(*out as usize).map(|to| distance::<T, 3>(to, at));
            let within = before.filter(|x| *x < T::of(f64::INFINITY)).unwrap_or(T::of(f64::INFINITY));
            *out = tree.nearest::<1>(at, within, None).index[0];
        }
    });
}

/// Mean squared distance of rows to those that `to` names.
fn mean<T: Float>(from: &[T], others: &[T], to: &[u32]) -> f64 {
    let rows = from.as_chunks::<3>().0.iter().zip(to).filter(|(_, to)| **to != NONE);
    let squared = |(p, to): (&[T; 3], &u32)| {
        let q = &others[3 * *to as usize..];
        (0..3).fold(T::ZERO, |sum, c| sum + (p[c] - q[c]) * (p[c] - q[c])).wide()
    };
    rows.map(squared).sum::<f64>() / to.len().max(1) as f64
}

impl Operation for Nearest {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.a), None, None]
    }

    fn scratch<T: Float>(&self) -> usize {
        let rows = self.a.rows.max(self.b.rows);
        tree_need::<T>(rows, 3)
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let (a, b) = (self.a.of(before), self.b.of(before));
        let tree = Tree::new(b, &mut run.scratch.frame())?;
        search(self.to_b.of_mut(run.indices), a, b, &tree, run.workers);
        let tree = Tree::new(a, &mut run.scratch.frame())?;
        search(self.to_a.of_mut(run.indices), b, a, &tree, run.workers);
        let means = [mean(a, b, self.to_b.of(run.indices)), mean(b, a, self.to_a.of(run.indices))];
        let is_second = means[1] > means[0];
        self.which.of_mut(run.indices)[0] = is_second as u32;
        y[0] = T::of(means[is_second as usize]);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let is_second = self.which.of(run.indices)[0] == 1;
        let table = if is_second { self.to_a } else { self.to_b }.of(run.indices);
        let share = T::of(2.0 * d_y[0].wide() / table.len().max(1) as f64);
        let (a, b, d_a) = (self.a.of(run.values), self.b.of(run.values), self.a.of_mut(before));
        for (i, &to) in table.iter().enumerate().filter(|(_, to)| **to != NONE) {
            let (i, j) = if is_second { (to as usize, i) } else { (i, to as usize) };
            (0..3).for_each(|c| d_a[3 * i + c] += share * (a[3 * i + c] - b[3 * j + c]));
        }
        Ok(())
    }
}
