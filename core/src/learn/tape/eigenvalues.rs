//! Departure from conformality: the mean difference of the eigenvalues of J^T J, J the 3 x 2 Jacobian of a point.
//!
//! With a = j1.j1, b = j1.j2, c = j2.j2 the difference is sqrt((a - c)^2 + 4 b^2); at zero no gradient flows.

use super::cosine::dot;
use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::Var;
use crate::base::real::sqrt;
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Y (1, 1) = mean |l1 - l2| over points. T (2n, 3) holds the first columns of all Jacobians, then the second.
#[derive(Clone, Copy, Debug)]
pub struct Eigenvalues {
    t: Var,
    y: Var,
}

impl<O: Operation + Copy + From<Eigenvalues>> Recording<O> {
    /// Mean difference of the eigenvalues of J^T J; see [`Eigenvalues`].
    pub fn eigenvalues(&mut self, t: Var) -> Var {
        debug_assert!(t.columns == 3 && t.rows.is_multiple_of(2), "two tangent columns in space");
        let y = self.output(1, 1, &[t]);
        self.push(Eigenvalues { t, y })
    }
}

/// (a - c, 2 b, their length).
fn spread<T: Float>(j1: &[T], j2: &[T]) -> (T, T, T) {
    let (stretch, shear) = (dot(j1, j1) - dot(j2, j2), dot(j1, j2) + dot(j1, j2));
    (stretch, shear, sqrt(stretch * stretch + shear * shear))
}

impl Operation for Eigenvalues {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.t), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let t = self.t.of(before);
        let (first, second) = (&t[..t.len() / 2], &t[t.len() / 2..]);
        let columns = first.as_chunks::<3>().0.iter().zip(second.as_chunks::<3>().0.iter());
        let sum: f64 = columns.map(|(j1, j2)| spread(j1, j2).2.wide()).sum();
        y[0] = T::of(sum / (self.t.rows / 2).max(1) as f64);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let n = self.t.rows / 2;
        let share = T::of(2.0 * d_y[0].wide() / n.max(1) as f64);
        let (t, _) = self.t.of(run.values).as_chunks::<3>();
        let (d_t, _) = self.t.of_mut(before).as_chunks_mut::<3>();
        for i in 0..n {
            let (j1, j2) = (&t[i], &t[n + i]);
            let (stretch, shear, length) = spread(j1, j2);
            if length > T::ZERO {
                let (p, q) = (share * stretch / length, share * shear / length);
                for c in 0..3 {
                    d_t[i][c] += p * j1[c] + q * j2[c];
                    d_t[n + i][c] += q * j1[c] - p * j2[c];
                }
            }
        }
        Ok(())
    }
}
