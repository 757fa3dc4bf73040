//! How far a map is from a given one: in its Jacobians, and in its places.
//!
//! Places alone say little about shape: a map may be near everywhere and folded all over. Both together are a Sobolev distance.

use super::distortion::{REST, jacobian, send};
use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{Table, Var};
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Values of a given Jacobian: 2 x 2, row by row.
pub const JACOBIAN: usize = 4;

/// Y (1, 1) = sum w |J - J0|^2 over faces, w their share of the area.
#[derive(Clone, Copy, Debug)]
pub struct JacobianGap {
    x: Var,
    faces: Table,
    rest: Var,
    wanted: Var,
    y: Var,
}

/// Y (1, 1) = mean over rows of |A - B|^2, B without gradient.
#[derive(Clone, Copy, Debug)]
pub struct MeanSquare {
    a: Var,
    b: Var,
    y: Var,
}

impl<O: Operation + Copy + From<JacobianGap> + From<MeanSquare>> Recording<O> {
    /// Distance of the Jacobians of the map `x` (n, 2) over `faces` with their `rest` (faces, 5, an input; see
    /// [`super::distortion::rest_of`]) from those `wanted` (faces, 4, an input).
    pub fn jacobian_gap(&mut self, x: Var, faces: Table, rest: Var, wanted: Var) -> Var {
        debug_assert!(x.columns == 2 && rest.columns == REST && faces.len == 3 * rest.rows && !rest.has_gradient);
        debug_assert!(wanted.columns == JACOBIAN && wanted.rows == rest.rows && !wanted.has_gradient);
        let y = self.output(1, 1, &[x]);
        self.push(JacobianGap { x, faces, rest, wanted, y })
    }

    /// Mean squared distance of the rows of `a` from those of `b` (an input).
    pub fn mean_square(&mut self, a: Var, b: Var) -> Var {
        debug_assert!((a.rows, a.columns) == (b.rows, b.columns) && !b.has_gradient, "fixed values of one shape");
        let y = self.output(1, 1, &[a]);
        self.push(MeanSquare { a, b, y })
    }
}

/// Each face with its rest shape and the Jacobian that is wanted of it.
fn faces_of<'v, T>(
    faces: &'v [u32],
    rest: &'v [T],
    wanted: &'v [T],
) -> impl Iterator<Item = (&'v [u32; 3], (&'v [T; REST], &'v [T; JACOBIAN]))> {
    faces.as_chunks::<3>().0.iter().zip(rest.as_chunks::<REST>().0.iter().zip(wanted.as_chunks::<JACOBIAN>().0))
}

/// J - J0.
fn gap<T: Float>(x: &[T], face: &[u32; 3], rest: &[T; REST], [a, b, c, d]: [T; JACOBIAN]) -> [[T; 2]; 2] {
    let j = jacobian(x, face, rest);
    [[j[0][0] - a, j[0][1] - b], [j[1][0] - c, j[1][1] - d]]
}

impl Operation for JacobianGap {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let [x, rest, wanted] = [self.x, self.rest, self.wanted].map(|var| var.of(before));
        let all = faces_of(self.faces.of(run.indices), rest, wanted).map(|(face, (rest, wanted))| {
            let [[a, b], [c, d]] = gap(x, face, rest, *wanted);
            (rest[4] * (a * a + b * b + c * c + d * d)).wide()
        });
        y[0] = T::of(all.sum());
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let (d_x, twice) = (self.x.of_mut(before), T::of(2.0) * d_y[0]);
        let [x, rest, wanted] = [self.x, self.rest, self.wanted].map(|var| var.of(run.values));
        for (face, (rest, wanted)) in faces_of(self.faces.of(run.indices), rest, wanted) {
            let share = twice * rest[4];
            send(d_x, face, rest, gap(x, face, rest, *wanted).map(|row| row.map(|d| d * share)));
        }
        Ok(())
    }
}

impl Operation for MeanSquare {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.a), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let pairs = self.a.of(before).iter().zip(self.b.of(before));
        let sum: f64 = pairs.map(|(a, b)| ((*a - *b) * (*a - *b)).wide()).sum();
        y[0] = T::of(sum / self.a.rows.max(1) as f64);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let share = T::of(2.0 * d_y[0].wide() / self.a.rows.max(1) as f64);
        let pairs = self.a.of(run.values).iter().zip(self.b.of(run.values));
        self.a.of_mut(before).iter_mut().zip(pairs).for_each(|(d, (a, b))| *d += share * (*a - *b));
        Ok(())
    }
}
