//! Affine layers: Y = act(X W^T + b), with LeakyReLU fused in, and the same layer on forward tangents.
//!
//! A tangent column t of X maps to t W^T, and LeakyReLU multiplies it by the slope at the primal's output; the columns of
//! all tangents are stacked as further rows, so that the layer is one product and its reverse is the layer's own.
//! LeakyReLU's slope is read off its output, whose sign is that of its input.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::Var;
use crate::base::scratch::{ScratchTooSmall, bytes_for};
use crate::base::slices::{Slices, take_first};
use crate::base::workers::{Workers, for_each_chunk};
use crate::learn::kernels::float::Float;
use crate::learn::kernels::product::{Finish, Shape, Start, product, slope_at};
use crate::learn::kernels::task::Matrix;
use core::num::NonZero;

/// Values that a task of an elementwise pass takes: 64 KB of f32. 2^12 costs more to hand out than to do.
const CHUNK: usize = 1 << 14;
/// Columns that a task sums for the bias.
const BIAS_CHUNK: usize = 32;

/// What follows the product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// Nothing.
    Linear,
    /// LeakyReLU.
    Leaky,
    /// The slope of LeakyReLU at the output of another layer: a tangent of that layer. No gradient flows through it.
    SlopeOf(Var),
}

/// Y (n, out) = act(X (n, in) W^T + b), W (out, in), b (1, out).
#[derive(Clone, Copy, Debug)]
pub struct Affine {
    x: Var,
    w: Var,
    b: Option<Var>,
    y: Var,
    activation: Activation,
}

impl<O: Operation + Copy + From<Affine>> Recording<O> {
    /// A layer; see [`Affine`].
    pub fn affine(&mut self, x: Var, w: Var, b: Option<Var>, activation: Activation) -> Var {
        debug_assert!(x.columns == w.columns && b.is_none_or(|b| b.count() == w.rows), "the layer's sizes agree");
        let y = self.output(x.rows, w.rows, &[x, w]);
        self.push(Affine { x, w, b, y, activation })
    }
}

impl Affine {
    fn shapes(&self) -> [Shape; 3] {
        let (n, inner, outer) = (self.x.rows, self.x.columns, self.y.columns);
        [
            Shape { rows: n, columns: outer, depth: inner },
            Shape { rows: n, columns: inner, depth: outer },
            Shape { rows: outer, columns: inner, depth: n },
        ]
    }
}

impl Operation for Affine {
    fn sets_fresh(&self) -> bool {
        true
    }

    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.x), Some(self.w), self.b]
    }

    fn scratch<T: Float>(&self) -> usize {
        bytes_for::<T>(self.shapes().iter().map(|shape| shape.packed()).max().unwrap_or(0))
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let shape = self.shapes()[0];
        let mut frame = run.scratch.frame();
        let packed = frame.take_unset(shape.packed())?;
        let (before, y) = self.y.split(run.values);
        let (x, w) = (Matrix::new(self.x.of(before), shape.depth), Matrix::new(self.w.of(before), shape.depth));
        let start = self.b.map_or(Start::Zero, |b| Start::Bias(b.of(before)));
        let finish = match self.activation {
            Activation::Linear => Finish::Nothing,
            Activation::Leaky => Finish::Leaky,
            Activation::SlopeOf(primal) => Finish::Masked(primal.of(before)),
        };
        product(y, shape, x, w.transposed(), start, finish, packed, run.path, run.workers);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, fresh: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let [_, to_inputs, to_weights] = self.shapes();
        let (inner, outer) = (self.x.columns, self.y.columns);
        let mut frame = run.scratch.frame();
        let packed = frame.take_unset(to_inputs.packed().max(to_weights.packed()))?;
        let (before, d_y) = self.y.split(run.gradients);
        match self.activation {
            Activation::Linear => {}
            Activation::Leaky => times_slope(d_y, self.y.of(run.values), run.workers),
            Activation::SlopeOf(primal) => times_slope(d_y, primal.of(run.values), run.workers),
        }
        let begin = |is_fresh: bool| if is_fresh { Start::Zero } else { Start::Sum };
        let d_y = &*d_y;
        if let Some(b) = self.b {
            for_each_chunk(run.workers, b.of_mut(before), BIAS_CHUNK, &|task, d_b| {
                if fresh[2] {
                    d_b.fill(T::ZERO);
                }
                for row in d_y.rows(outer) {
                    d_b.iter_mut().zip(&row[task * BIAS_CHUNK..]).for_each(|(b, y)| *b += *y);
                }
            });
        }
        if self.w.has_gradient {
            let (a, x) = (Matrix::new(d_y, outer).transposed(), Matrix::new(self.x.of(run.values), inner));
            let d_w = self.w.of_mut(before);
            product(d_w, to_weights, a, x, begin(fresh[1]), Finish::Nothing, packed, run.path, run.workers);
        }
        if self.x.has_gradient {
            let (a, w) = (Matrix::new(d_y, outer), Matrix::new(self.w.of(run.values), inner));
            let d_x = self.x.of_mut(before);
            product(d_x, to_inputs, a, w, begin(fresh[0]), Finish::Nothing, packed, run.path, run.workers);
        }
        Ok(())
    }
}

/// Multiplies each value of `d` by the slope of LeakyReLU where its output is `y`, which repeats along `d`.
fn times_slope<T: Float>(d: &mut [T], y: &[T], workers: &dyn Workers) {
    let Some(len) = NonZero::new(y.len()) else { return };
    for_each_chunk(workers, d, CHUNK, &|task, mut d| {
        let mut at = task * CHUNK % len;
        while !d.is_empty() {
            let now = d.len().min(y.len() - at);
            take_first(&mut d, now).iter_mut().zip(&y[at..]).for_each(|(d, y)| *d = *d * slope_at(*y));
            at = 0;
        }
    });
}
