//! Jacobians of triangles and penalties on them: a hinge on their determinants (folds, collapsed area) and a symmetric
//! Dirichlet energy that goes on past a fold.
//!
//! J_f maps the plane of face f in space to UV: its columns are the images of an orthonormal frame, so det J_f is the
//! face's signed area in UV over its area in space. Both penalties divide by the map's own scale s, the total signed area
//! in UV over that in space, so that neither the size of the map nor its turning side matters: a face is folded where
//! its sign is not that of the whole. No gradient flows through s.
//! The energy (Smith, Schaefer, *Bijective parameterization with free boundaries*, 2015) is |J|^2 (1 + 1/det^2); below
//! [`BEND`] the factor 1/det^2 goes on along its tangent, so that folded faces, where the energy itself would keep them
//! folded, are pushed back. It is 4 for an isometry; the penalty is what it exceeds that by.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{Table, Var};
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Determinant below which the barrier is its own tangent. 0.05 made steps of 1e-3 overshoot, 0.2 lets faces collapse.
pub const BEND: f64 = 0.1;
/// Columns of the rest table: the inverse of the face's frame (2 x 2, row by row) and its share of the area.
pub const REST: usize = 5;

/// Y (1, 1) = sum w det J, the map's scale and side; no gradient flows to X.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    x: Var,
    faces: Table,
    rest: Var,
    y: Var,
}

/// Y (1, 1) = sum w max(0, margin - det J / s)^2: 0 where every face keeps `margin` of the mean area ratio.
#[derive(Clone, Copy, Debug)]
pub struct Hinge {
    x: Var,
    faces: Table,
    rest: Var,
    scale: Var,
    y: Var,
    margin: f64,
}

/// Y (1, 1) = sum w (|J|^2/|s| (1 + g(det J / s)) - 4), g(d) = 1/d^2, below [`BEND`] its tangent there.
#[derive(Clone, Copy, Debug)]
pub struct Barrier {
    x: Var,
    faces: Table,
    rest: Var,
    scale: Var,
    y: Var,
}

impl<O: Operation + Copy + From<Scale> + From<Hinge> + From<Barrier>> Recording<O> {
    /// The scale of the map `x` (n, 2) over `faces` with their `rest` (faces, 5, an input; see [`rest_of`]).
    pub fn scale(&mut self, x: Var, faces: Table, rest: Var) -> Var {
        debug_assert!(x.columns == 2 && rest.columns == REST && faces.len == 3 * rest.rows && !rest.has_gradient);
        let y = self.output(1, 1, &[]);
        self.push(Scale { x, faces, rest, y })
    }

    /// Penalty on folds and collapsed area; see [`Hinge`].
    pub fn hinge(&mut self, x: Var, faces: Table, rest: Var, scale: Var, margin: f64) -> Var {
        debug_assert!(x.columns == 2 && rest.columns == REST && faces.len == 3 * rest.rows);
        let y = self.output(1, 1, &[x]);
        self.push(Hinge { x, faces, rest, scale, y, margin })
    }

    /// Symmetric Dirichlet energy past folds; see [`Barrier`].
    pub fn barrier(&mut self, x: Var, faces: Table, rest: Var, scale: Var) -> Var {
        debug_assert!(x.columns == 2 && rest.columns == REST && faces.len == 3 * rest.rows);
        let y = self.output(1, 1, &[x]);
        self.push(Barrier { x, faces, rest, scale, y })
    }
}

/// The inverse of a face's frame, row by row, and its area: of corners `p` in space, in f64. A face without area gives
/// zeros, which takes it out of every sum.
pub fn rest_of(p: [[f64; 3]; 3]) -> [f64; REST] {
    use crate::base::real::sqrt;
    let side = |k: usize| [p[k][0] - p[0][0], p[k][1] - p[0][1], p[k][2] - p[0][2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (u, v) = (side(1), side(2));
    let length = sqrt(dot(u, u));
    let along = dot(u, v) / length;
    // The frame has (length, 0) and (along, height) as the two sides.
    let height = sqrt((dot(v, v) - along * along).max(0.0));
    let area = 0.5 * length * height;
    if !(area.is_finite() && area > 0.0 && (1.0 / height).is_finite() && (1.0 / length).is_finite()) {
        return [0.0; REST];
    }
    [1.0 / length, -along / (length * height), 0.0, 1.0 / height, area]
}

/// J of a face: the sides in UV times the inverse frame.
pub(super) fn jacobian<T: Float>(x: &[T], face: &[u32], rest: &[T]) -> [[T; 2]; 2] {
    let at = |k: usize, c: usize| x[2 * face[k] as usize + c];
    core::array::from_fn(|c| {
        let (u, v) = (at(1, c) - at(0, c), at(2, c) - at(0, c));
        [u * rest[0] + v * rest[2], u * rest[1] + v * rest[3]]
    })
}

fn determinant<T: Float>(j: [[T; 2]; 2]) -> T {
    j[0][0] * j[1][1] - j[0][1] * j[1][0]
}

/// d det / d J.
fn cofactors<T: Float>(j: [[T; 2]; 2]) -> [[T; 2]; 2] {
    [[j[1][1], -j[1][0]], [-j[0][1], j[0][0]]]
}

/// Sends a gradient with respect to J to the corners.
pub(super) fn send<T: Float>(d_x: &mut [T], face: &[u32], rest: &[T], d_j: [[T; 2]; 2]) {
    for (c, d) in d_j.into_iter().enumerate() {
        let (u, v) = (d[0] * rest[0] + d[1] * rest[1], d[0] * rest[2] + d[1] * rest[3]);
        d_x[2 * face[1] as usize + c] += u;
        d_x[2 * face[2] as usize + c] += v;
        d_x[2 * face[0] as usize + c] += -(u + v);
    }
}

/// (g, g') of the barrier.
fn bent<T: Float>(d: T) -> (T, T) {
    let bend = T::of(BEND);
    let at = if d > bend { d } else { bend };
    let (value, slope) = (T::ONE / (at * at), T::of(-2.0) / (at * at * at));
    if d > bend { (value, slope) } else { (value + slope * (d - bend), slope) }
}

/// Sum over faces of w f(J, 1/s), in order; 0 for a map without area.
fn sum<T: Float>([x, rest, scale]: [&[T]; 3], faces: &[u32], mut term: impl FnMut([[T; 2]; 2], T) -> T) -> f64 {
    let inverse = T::ONE / scale[0];
    if !inverse.wide().is_finite() {
        return 0.0;
    }
    let faces =
        faces.as_chunks::<3>().0.iter().zip(rest.as_chunks::<REST>().0.iter()).filter(|(_, rest)| rest[4] > T::ZERO);
    faces.map(|(face, rest)| rest[4].wide() * term(jacobian(x, face, rest), inverse).wide()).sum()
}

/// Adds to d_x the gradient of that sum times `share`, `slope` giving the derivative of f with respect to J.
fn spread<T: Float>(
    d_x: &mut [T],
    [x, rest, scale]: [&[T]; 3],
    faces: &[u32],
    share: T,
    mut slope: impl FnMut([[T; 2]; 2], T) -> [[T; 2]; 2],
) {
    let inverse = T::ONE / scale[0];
    if !inverse.wide().is_finite() {
        return;
    }
    for (face, rest) in
        faces.as_chunks::<3>().0.iter().zip(rest.as_chunks::<REST>().0.iter()).filter(|(_, rest)| rest[4] > T::ZERO)
    {
        let d_j = slope(jacobian(x, face, rest), inverse);
        send(d_x, face, rest, d_j.map(|row| row.map(|d| d * share * rest[4])));
    }
}

impl Operation for Scale {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [None; 3]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let parts = [self.x.of(before), self.rest.of(before), &[T::ONE]];
        y[0] = T::of(sum(parts, self.faces.of(run.indices), |j, _| determinant(j)));
        Ok(())
    }

    fn backward<T: Float>(&self, _: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        Ok(()) // the scale is a measure, not a way for gradients
    }
}

impl Operation for Hinge {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let parts = [self.x, self.rest, self.scale].map(|var| var.of(before));
        y[0] = T::of(sum(parts, self.faces.of(run.indices), |j, inverse| {
            let lack = T::of(self.margin) - determinant(j) * inverse;
            if lack > T::ZERO { lack * lack } else { T::ZERO }
        }));
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let parts = [self.x, self.rest, self.scale].map(|var| var.of(run.values));
        spread(self.x.of_mut(before), parts, self.faces.of(run.indices), d_y[0], |j, inverse| {
            let lack = T::of(self.margin) - determinant(j) * inverse;
            let pull = if lack > T::ZERO { T::of(-2.0) * lack * inverse } else { T::ZERO };
            cofactors(j).map(|row| row.map(|c| c * pull))
        });
        Ok(())
    }
}

impl Operation for Barrier {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let parts = [self.x, self.rest, self.scale].map(|var| var.of(before));
        y[0] = T::of(sum(parts, self.faces.of(run.indices), |j, inverse| {
            let (size, g) = (norm(j, inverse), bent(determinant(j) * inverse).0);
            size * (T::ONE + g) - T::of(4.0)
        }));
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let parts = [self.x, self.rest, self.scale].map(|var| var.of(run.values));
        spread(self.x.of_mut(before), parts, self.faces.of(run.indices), d_y[0], |j, inverse| {
            let (g, slope) = bent(determinant(j) * inverse);
            let to_size = T::of(2.0) * (T::ONE + g) * absolute(inverse);
            let to_determinant = norm(j, inverse) * slope * inverse;
            let cofactors = cofactors(j);
            core::array::from_fn(|r| core::array::from_fn(|c| to_size * j[r][c] + to_determinant * cofactors[r][c]))
        });
        Ok(())
    }
}

fn absolute<T: Float>(x: T) -> T {
    if x < T::ZERO { -x } else { x }
}

/// |J|^2 / |s|.
fn norm<T: Float>(j: [[T; 2]; 2], inverse: T) -> T {
    let squares = j[0][0] * j[0][0] + j[0][1] * j[0][1] + j[1][0] * j[1][0] + j[1][1] * j[1][1];
    squares * absolute(inverse)
}
