//! Repulsion: points of a map that lie closer to their nearest ones than a radius push these away.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{NONE, Table, Var};
use crate::base::real::sqrt;
use crate::base::scratch::ScratchTooSmall;
use crate::base::slices::Slices;
use crate::base::workers::for_each_chunk;
use crate::learn::kernels::float::Float;
use crate::learn::near::{Tree, tree_need};

/// Nearest points that count.
pub const NEIGHBOURS: usize = 8;
/// Added to squared distances, so that coinciding points have a finite gradient.
const TINY: f64 = 1e-8;
/// Queries of a task: about 0.1 ms.
const CHUNK: usize = 64 * NEIGHBOURS;

/// Y (1, 1) = mean over rows and their 8 nearest others of max(0, radius - sqrt(d^2 + 1e-8)). With fewer than 8 others
/// the mean is over those.
#[derive(Clone, Copy, Debug)]
pub struct Repel {
    x: Var,
    y: Var,
    near: Table, // (n, 8): those within the radius, then NONE
    radius: f64,
}

impl<O: Operation + Copy + From<Repel>> Recording<O> {
    /// Hinge repulsion of the rows of `x` within `radius`.
    pub fn repel(&mut self, x: Var, radius: f64) -> Var {
        debug_assert!(x.columns == 2, "points of the plane");
        let near = self.table(x.rows * NEIGHBOURS);
        let y = self.output(1, 1, &[x]);
        self.push(Repel { x, y, near, radius })
    }
}

impl Repel {
    fn terms(&self) -> f64 {
        (self.x.rows * NEIGHBOURS.min(self.x.rows.saturating_sub(1))).max(1) as f64
    }
}

/// (x_i - x_j, its softened length).
fn between<T: Float>(x: &[T], i: usize, j: u32) -> ([T; 2], T) {
    let gap = [x[2 * i] - x[2 * j as usize], x[2 * i + 1] - x[2 * j as usize + 1]];
    (gap, sqrt(gap[0] * gap[0] + gap[1] * gap[1] + T::of(TINY)))
}

impl Operation for Repel {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn scratch<T: Float>(&self) -> usize {
        tree_need::<T>(self.x.rows, 2)
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let (x, radius) = (self.x.of(before), T::of(self.radius));
        let tree = Tree::<T, 2>::new(x, &mut run.scratch.frame())?;
        // What lies beyond the radius adds nothing, so it need not be found.
        for_each_chunk(run.workers, self.near.of_mut(run.indices), CHUNK, &|task, near| {
            for (k, near) in near.as_chunks_mut::<NEIGHBOURS>().0.iter_mut().enumerate() {
                let i = task * (CHUNK / NEIGHBOURS) + k;
                let found = tree.nearest::<NEIGHBOURS>(&x[2 * i..][..2], radius * radius, Some(i as u32));
                near.copy_from(&found.index);
                near[found.len..].fill(NONE);
            }
        });
        let mut sum = 0.0;
        for (i, near) in self.near.of(run.indices).as_chunks::<NEIGHBOURS>().0.iter().enumerate() {
            for &j in near.iter().take_while(|j| **j != NONE) {
                let length = between(x, i, j).1;
                if length < radius {
                    sum += (radius - length).wide();
                }
            }
        }
        y[0] = T::of(sum / self.terms());
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let (share, radius) = (T::of(d_y[0].wide() / self.terms()), T::of(self.radius));
        let (x, d_x) = (self.x.of(run.values), self.x.of_mut(before));
        for (i, near) in self.near.of(run.indices).as_chunks::<NEIGHBOURS>().0.iter().enumerate() {
            for &j in near.iter().take_while(|j| **j != NONE) {
                let (gap, length) = between(x, i, j);
                if length < radius {
                    let pull = share / length;
                    for c in 0..2 {
                        d_x[2 * i + c] += -(pull * gap[c]);
                        d_x[2 * j as usize + c] += pull * gap[c];
                    }
                }
            }
        }
        Ok(())
    }
}
