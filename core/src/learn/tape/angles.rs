//! Triangles' angles in UV against those in space, by their cosines.

use super::cosine::dot;
use super::means::sign;
use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::{Table, Var};
use crate::base::real::sqrt;
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Y (1, 1) = mean over the corners of all faces of |cosine in UV - the one in space|. `faces` names three rows of X a
/// face, `target` (faces, 3) holds the cosines in space. A corner at a side without length has the cosine 0.
#[derive(Clone, Copy, Debug)]
pub struct Angles {
    x: Var,
    faces: Table,
    target: Var,
    y: Var,
}

impl<O: Operation + Copy + From<Angles>> Recording<O> {
    /// Mean difference of corner cosines; see [`Angles`].
    pub fn angles(&mut self, x: Var, faces: Table, target: Var) -> Var {
        debug_assert!(x.columns == 2 && faces.len == target.count() && target.columns == 3 && !target.has_gradient);
        let y = self.output(1, 1, &[x]);
        self.push(Angles { x, faces, target, y })
    }
}

/// The sides from corner `c` of the triangle `at` of rows of `x` with their lengths.
struct Corner<T, const D: usize> {
    sides: [[T; D]; 2],
    lengths: [T; 2],
}

impl<T: Float, const D: usize> Corner<T, D> {
    fn new(x: &[T], at: [usize; 3]) -> Self {
        let side = |to: usize| core::array::from_fn(|k| x[D * to + k] - x[D * at[0] + k]);
        let sides: [[T; D]; 2] = [side(at[1]), side(at[2])];
        Self { sides, lengths: sides.map(|s| sqrt(dot(&s, &s))) }
    }

    fn cosine(&self) -> T {
        let lengths = self.lengths[0] * self.lengths[1];
        if lengths > T::ZERO { dot(&self.sides[0], &self.sides[1]) / lengths } else { T::ZERO }
    }
}

/// The rows of a face, corner `c` first.
fn turned(face: &[u32], c: usize) -> [usize; 3] {
    core::array::from_fn(|k| face[(c + k) % 3] as usize)
}

/// Cosine at each corner of a triangle in space: what [`Angles`] compares with.
pub fn cosines<T: Float>(positions: &[T], face: [u32; 3]) -> [T; 3] {
    core::array::from_fn(|c| Corner::<T, 3>::new(positions, turned(&face, c)).cosine())
}

impl Operation for Angles {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let (x, target) = (self.x.of(before), self.target.of(before));
        let mut sum = 0.0;
        for (face, target) in self.faces.of(run.indices).as_chunks::<3>().0.iter().zip(target.as_chunks::<3>().0.iter())
        {
            for (c, &target) in target.iter().enumerate() {
                let excess = Corner::<T, 2>::new(x, turned(face, c)).cosine() - target;
                sum += (excess * sign(excess)).wide();
            }
        }
        y[0] = T::of(sum / self.target.count().max(1) as f64);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let share = T::of(d_y[0].wide() / self.target.count().max(1) as f64);
        let (x, d_x, target) = (self.x.of(run.values), self.x.of_mut(before), self.target.of(run.values));
        for (face, target) in self.faces.of(run.indices).as_chunks::<3>().0.iter().zip(target.as_chunks::<3>().0.iter())
        {
            for (c, &target) in target.iter().enumerate() {
                let at = turned(face, c);
                let corner = Corner::<T, 2>::new(x, at);
                let [u, v] = corner.lengths;
                if u * v <= T::ZERO {
                    continue;
                }
                let cosine = corner.cosine();
                let pull = share * sign(cosine - target);
                for k in 0..2 {
                    let (along_u, along_v) = (corner.sides[0][k] / u, corner.sides[1][k] / v);
                    let d_u = pull * (along_v - cosine * along_u) / u;
                    let d_v = pull * (along_u - cosine * along_v) / v;
                    d_x[2 * at[1] + k] += d_u;
                    d_x[2 * at[2] + k] += d_v;
                    d_x[2 * at[0] + k] += -(d_u + d_v);
                }
            }
        }
        Ok(())
    }
}
