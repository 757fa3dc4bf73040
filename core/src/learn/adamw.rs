//! AdamW with a cosine schedule.
//!
//! Loshchilov, Hutter, *Decoupled weight decay regularization*, ICLR 2019; the schedule without restarts of their *SGDR*,
//! ICLR 2017. Each weight is updated alone, so tasks do not change the result.

use super::kernels::float::Float;
use crate::base::real::{cos, pow, sqrt};
use crate::base::workers::{Workers, for_each_chunk};

/// Decay of the first moment.
const BETA1: f64 = 0.9;
/// Decay of the second moment.
const BETA2: f64 = 0.999;
/// Added to the root of the second moment (as published; the usual 1e-8 lets weights with tiny gradients jump).
const EPSILON: f64 = 1e-5;
/// Weight decay, in units of the rate.
const DECAY: f64 = 1e-8;
/// Weights of a task.
const CHUNK: usize = 1 << 14;

/// Rate of step `step` of `steps`: from `first` to `last` by half a cosine.
pub fn cosine_rate(first: f64, last: f64, step: usize, steps: usize) -> f64 {
    let done = step.min(steps) as f64 / steps.max(1) as f64;
    last + 0.5 * (first - last) * (1.0 + cos(core::f64::consts::PI * done))
}

/// Moves `weights` against `gradients`; `moments` holds (first, second) for each weight, zero before the first step;
/// `step` counts from 1.
pub fn update<T: Float>(
    weights: &mut [T],
    moments: &mut [T], // (weights, 2)
    gradients: &[T],
    rate: f64,
    step: usize,
    workers: &dyn Workers,
) {
    let (keep, add) = (T::of(BETA1), T::of(1.0 - BETA1));
    let (keep2, add2) = (T::of(BETA2), T::of(1.0 - BETA2));
    let size = T::of(rate / (1.0 - pow(BETA1, step as f64)));
    let scale = T::of(1.0 / sqrt(1.0 - pow(BETA2, step as f64)));
    let (shrink, epsilon) = (T::of(1.0 - rate * DECAY), T::of(EPSILON));
    for_each_chunk(workers, moments, 2 * CHUNK, &|task, moments| {
        for (m, g) in moments.as_chunks_mut::<2>().0.iter_mut().zip(&gradients[task * CHUNK..]) {
            m[0] = keep * m[0] + add * *g;
            m[1] = keep2 * m[1] + add2 * *g * *g;
        }
    });
    let moments = &*moments;
    for_each_chunk(workers, weights, CHUNK, &|task, weights| {
        for (w, m) in weights.iter_mut().zip(moments[2 * task * CHUNK..].as_chunks::<2>().0.iter()) {
            *w = shrink * *w - size * m[0] / (sqrt(m[1]) * scale + epsilon);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_first_step_moves_each_weight_by_the_rate_against_its_sign() {
        // With both moments corrected, step 1 is rate g / (|g| + eps): the rate itself but for eps/|g| = 1e-5.
        let (mut weights, mut moments) = ([0.5, -0.5, 2.0], [0.0; 6]);
        update(&mut weights, &mut moments, &[1.0, -1.0, 0.0], 1e-3, 1, &Serial);
        assert_abs_diff_eq!(weights[0], 0.499f64, epsilon = 2e-8);
        assert_abs_diff_eq!(weights[1], -0.499, epsilon = 2e-8);
        assert!((weights[2] - 2.0).abs() < 1e-10, "decay alone: 2 x 1e-11");
    }

    #[test]
    fn the_rate_falls_from_first_to_last() {
        let rate = |step| cosine_rate(1e-3, 1e-5, step, 100);
        assert!(
            (rate(0) - 1e-3).abs() < 1e-15 && (rate(100) - 1e-5).abs() < 1e-15 && (rate(50) - 5.05e-4).abs() < 1e-15
        );
        assert!((1..=100).all(|step| rate(step) < rate(step - 1)));
    }
}
