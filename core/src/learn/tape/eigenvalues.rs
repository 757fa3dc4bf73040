//! Departure from conformality: the mean difference of the eigenvalues of J^T J, J the 3 x 2 Jacobian of a point.
//!
//! With a = j1.j1, b = j1.j2, c = j2.j2 the difference is sqrt((a - c)^2 + 4 b^2); at zero no gradient flows.

use super::cosine::dot;
use super::{Operation, Replay, Tape, Var};
use crate::base::real::sqrt;
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::Float;

/// Y (1, 1) = mean |l1 - l2| over points. T (2n, 3) holds the first columns of all Jacobians, then the second.
#[derive(Clone, Copy, Debug)]
pub struct Eigenvalues {
    t: Var,
    y: Var,
}

impl Tape {
    /// Mean difference of the eigenvalues of J^T J; see [`Eigenvalues`].
    pub fn eigenvalues(&mut self, t: Var) -> Var {
        assert!(t.columns == 3 && t.rows.is_multiple_of(2), "two tangent columns in space");
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
        let (first, second) = self.t.of(before).split_at(self.t.count() / 2);
        let columns = first.chunks_exact(3).zip(second.chunks_exact(3));
        let sum: f64 = columns.map(|(j1, j2)| spread(j1, j2).2.wide()).sum();
        y[0] = T::of(sum / (self.t.rows / 2).max(1) as f64);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let n = self.t.rows / 2;
        let share = T::of(2.0 * d_y[0].wide() / n.max(1) as f64);
        let (first, second) = self.t.of(run.values).split_at(3 * n);
        let (d_first, d_second) = self.t.of_mut(before).split_at_mut(3 * n);
        for i in (0..3 * n).step_by(3) {
            let (j1, j2) = (&first[i..i + 3], &second[i..i + 3]);
            let (stretch, shear, length) = spread(j1, j2);
            if length > T::ZERO {
                let (p, q) = (share * stretch / length, share * shear / length);
                for c in 0..3 {
                    d_first[i + c] += p * j1[c] + q * j2[c];
                    d_second[i + c] += q * j1[c] - p * j2[c];
                }
            }
        }
        Ok(())
    }
}
