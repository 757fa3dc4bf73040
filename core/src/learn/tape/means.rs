//! Means: of absolute differences, and weighted by scores. Sums are kept in f64, in order.

use super::operation::{Operation, Replay};
use super::recording::Recording;
use super::var::Var;
use crate::base::scratch::ScratchTooSmall;
use crate::learn::kernels::float::Float;

/// Keeps the weighted mean finite where all scores vanish.
const TINY: f64 = 1e-6;

/// Y (1, 1) = mean of |A - B| over all elements; no gradient where they are equal.
#[derive(Clone, Copy, Debug)]
pub struct MeanAbs {
    a: Var,
    b: Var,
    y: Var,
}

/// Y (1, 1) = sum s w / (sum s + 1e-6), w without gradient.
#[derive(Clone, Copy, Debug)]
pub struct WeightedMean {
    s: Var,
    w: Var,
    y: Var,
}

impl<O: Operation + Copy + From<MeanAbs> + From<WeightedMean>> Recording<O> {
    /// Mean absolute difference of two values of one shape.
    pub fn mean_abs(&mut self, a: Var, b: Var) -> Var {
        debug_assert_eq!((a.rows, a.columns), (b.rows, b.columns), "values of one shape");
        let y = self.output(1, 1, &[a, b]);
        self.push(MeanAbs { a, b, y })
    }

    /// Mean of `w` (an input), each weighted by the score `s`.
    pub fn weighted_mean(&mut self, s: Var, w: Var) -> Var {
        debug_assert!(s.count() == w.count() && !w.has_gradient, "a fixed value for each score");
        let y = self.output(1, 1, &[s]);
        self.push(WeightedMean { s, w, y })
    }
}

/// 1, -1, or 0 at zero and for NaN.
pub(super) fn sign<T: Float>(x: T) -> T {
    if x > T::ZERO {
        T::ONE
    } else if x < T::ZERO {
        -T::ONE
    } else {
        T::ZERO
    }
}

impl Operation for MeanAbs {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.a), Some(self.b), None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let pairs = self.a.of(before).iter().zip(self.b.of(before));
        let sum: f64 = pairs.map(|(a, b)| ((*a - *b) * sign(*a - *b)).wide()).sum();
        y[0] = T::of(sum / self.a.count().max(1) as f64);
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let share = T::of(d_y[0].wide() / self.a.count().max(1) as f64);
        let (a, b) = (self.a.of(run.values), self.b.of(run.values));
        for (x, share) in [(self.a, share), (self.b, -share)] {
            if x.has_gradient {
                let pairs = a.iter().zip(b);
                x.of_mut(before).iter_mut().zip(pairs).for_each(|(d, (a, b))| *d += share * sign(*a - *b));
            }
        }
        Ok(())
    }
}

impl Operation for WeightedMean {
    fn output(&self) -> Var {
        self.y
    }

    fn inputs(&self) -> [Option<Var>; 3] {
        [Some(self.s), None, None]
    }

    fn forward<T: Float>(&self, run: &mut Replay<T>) -> Result<(), ScratchTooSmall> {
        let (before, y) = self.y.split(run.values);
        let (s, w) = (self.s.of(before), self.w.of(before));
        let products: f64 = s.iter().zip(w).map(|(s, w)| s.wide() * w.wide()).sum();
        let scores: f64 = s.iter().map(|s| s.wide()).sum();
        y[0] = T::of(products / (scores + TINY));
        Ok(())
    }

    fn backward<T: Float>(&self, run: &mut Replay<T>, _: [bool; 3]) -> Result<(), ScratchTooSmall> {
        let (before, d_y) = self.y.split(run.gradients);
        let scores: f64 = self.s.of(run.values).iter().map(|s| s.wide()).sum();
        let (mean, share) = (self.y.of(run.values)[0].wide(), d_y[0].wide() / (scores + TINY));
        let pairs = self.s.of_mut(before).iter_mut().zip(self.w.of(run.values));
        pairs.for_each(|(d, w)| *d += T::of(share * (w.wide() - mean)));
        Ok(())
    }
}
