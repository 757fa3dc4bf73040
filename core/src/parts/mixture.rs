//! A mixture of Gaussians over one number a face, fitted by expectation and maximisation.
//!
//! Values in [0, 1] are counted in [`BINS`] bins first, so an iteration costs O(bins K) however large the mesh is; the
//! floor under the variance is wider than a bin, so nothing that the fit can resolve is lost. Components start at the
//! quantiles (k + 1/2)/K with a common variance; responsibilities go through log-sum-exp. The number of components can be
//! left to the Bayesian information criterion (Schwarz 1978): least (3 K - 1) ln n - 2 ln L.
//! Dempster, Laird, Rubin 1977. Equal input gives equal bits; a local optimum is all that is promised.

use crate::base::real;
use crate::base::room::Room;
use crate::base::sort;
use core::f64::consts::TAU;

/// Components at the most.
pub const MAX_COMPONENTS: usize = 16;
/// Bins over [0, 1]. 256 move borders visibly; 4096 cost more and change no label.
const BINS: usize = 1024;
/// Least variance: two bins' width squared.
const VARIANCE_FLOOR: f64 = 4.0 / (BINS * BINS) as f64;
/// Rounds of the fit at the most; most meshes need 20 to 100.
const ROUNDS: usize = 200;
/// The fit ends when a value's mean log-likelihood grows by less.
const TOLERANCE: f64 = 1e-7;
/// Components that the information criterion tries.
const MAX_AUTO: usize = 8;

/// One Gaussian of the mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Share of the values.
    pub weight: f64,
    /// Mean.
    pub mean: f64,
    /// Variance, at least the floor.
    pub variance: f64,
}

/// A fitted mixture, components by mean.
pub type Mixture = heapless::Vec<Component, MAX_COMPONENTS>;

/// How many values fell into each bin.
pub struct Histogram {
    count: [f64; BINS],
    total: f64,
}

impl Histogram {
    /// Counts `values`; those that are NaN are left out, others clamped to [0, 1].
    pub fn new(values: &[f32]) -> Self {
        let mut count = [0.0; BINS];
        let mut total = 0.0;
        for x in values.iter().filter(|x| !x.is_nan()) {
            count[((*x * BINS as f32) as usize).min(BINS - 1)] += 1.0;
            total += 1.0;
        }
        Self { count, total }
    }

    /// Middles and counts of the bins that are not empty.
    fn bins(&self) -> impl Iterator<Item = (f64, f64)> {
        let middle = |i: usize| (i as f64 + 0.5) / BINS as f64;
        self.count.iter().enumerate().filter(|(_, n)| **n > 0.0).map(move |(i, n)| (middle(i), *n))
    }

    fn quantile(&self, share: f64) -> f64 {
        let mut below = 0.0;
        let reached = |(_, n): &(f64, f64)| {
            below += n;
            below >= share * self.total
        };
        self.bins().find(reached).map_or(0.5, |b| b.0)
    }
}

/// ln(weight) + ln of the component's density at x.
fn log_density(component: &Component, x: f64) -> f64 {
    let d = x - component.mean;
    real::ln(component.weight) - 0.5 * (real::ln(TAU * component.variance) + d * d / component.variance)
}

/// Fills `out` with each component's posterior probability at `x` and returns the log of the mixture's density there.
pub fn posterior(out: &mut [f64; MAX_COMPONENTS], mixture: &[Component], x: f64) -> f64 {
    let mut highest = f64::NEG_INFINITY;
    for (out, component) in out.iter_mut().zip(mixture) {
        *out = log_density(component, x);
        highest = if *out > highest { *out } else { highest };
    }
    let mut sum = 0.0;
    for out in out[..mixture.len()].iter_mut() {
        *out = real::exp(*out - highest);
        sum += *out;
    }
    out[..mixture.len()].iter_mut().for_each(|p| *p /= sum);
    highest + real::ln(sum)
}

/// Fits `components` Gaussians (1 to [`MAX_COMPONENTS`]); returns them with the log-likelihood of all values. No values:
/// equal components over [0, 1].
pub fn fit(histogram: &Histogram, components: usize) -> (Mixture, f64) {
    let k = components.clamp(1, MAX_COMPONENTS);
    let mut mixture = Mixture::new();
    for i in 0..k {
        let mean = histogram.quantile((i as f64 + 0.5) / k as f64);
        mixture.put(Component { weight: 1.0 / k as f64, mean, variance: 0.1 / (k * k) as f64 });
    }
    let mut likelihood = f64::NEG_INFINITY;
    for _ in 0..ROUNDS {
        let next = step(&mut mixture, histogram);
        let grown = next - likelihood;
        likelihood = next;
        if grown <= TOLERANCE * histogram.total {
            break;
        }
    }
    sort::by(&mut mixture, |a, b| a.mean.total_cmp(&b.mean));
    (mixture, likelihood)
}

/// One round; returns the log-likelihood before it.
fn step(mixture: &mut Mixture, histogram: &Histogram) -> f64 {
    let mut sums = [[0.0; 3]; MAX_COMPONENTS]; // 1, x, x^2
    let mut p = [0.0; MAX_COMPONENTS];
    let mut likelihood = 0.0;
    for (x, n) in histogram.bins() {
        likelihood += n * posterior(&mut p, mixture, x);
        for (sums, p) in sums.iter_mut().zip(&p[..mixture.len()]) {
            *sums = [sums[0] + n * p, sums[1] + n * p * x, sums[2] + n * p * x * x];
        }
    }
    for (component, [mass, x, xx]) in mixture.iter_mut().zip(sums) {
        // A component that has lost all values stays where it is, with next to no weight.
        component.weight = if mass > 1e-12 * histogram.total { mass / histogram.total } else { 1e-12 };
        if mass > 1e-9 {
            component.mean = x / mass;
            component.variance = (xx / mass - component.mean * component.mean).max(VARIANCE_FLOOR);
        }
    }
    likelihood
}

/// Fits with the number of components that the Bayesian information criterion prefers, 1 to 8; the fewer of equals.
pub fn fit_auto(histogram: &Histogram) -> Mixture {
    let mut best: Option<(f64, Mixture)> = None;
    for k in 1..=MAX_AUTO {
        let (mixture, likelihood) = fit(histogram, k);
        let cost = (3 * k - 1) as f64 * real::ln(histogram.total.max(1.0)) - 2.0 * likelihood;
        if best.as_ref().is_none_or(|b| cost < b.0) {
            best = Some((cost, mixture));
        }
    }
    best.map_or_else(Mixture::new, |b| b.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use approx::assert_abs_diff_eq;
    use std::vec::Vec;

    /// Sums of twelve uniform values are nearly normal.
    fn normal(mean: f64, deviation: f64, count: u64, stream: u64) -> impl Iterator<Item = f32> {
        let sum = move |i: u64| (0..12).map(|k| unit_f64(7, stream, 12 * i + k)).sum::<f64>() - 6.0;
        (0..count).map(move |i| (mean + deviation * sum(i)) as f32)
    }

    #[test]
    fn two_apart_gaussians_are_found_with_their_shares() {
        let values: Vec<f32> = normal(0.2, 0.03, 3000, 1).chain(normal(0.7, 0.05, 1000, 2)).collect();
        let mixture = fit_auto(&Histogram::new(&values));
        assert_eq!(mixture.len(), 2);
        // Standard errors of mean and deviation are below 0.002; five of them.
        let [a, b] = [mixture[0], mixture[1]];
        assert_abs_diff_eq!(a.weight, 0.75, epsilon = 1e-3);
        assert_abs_diff_eq!(a.mean, 0.2, epsilon = 0.005);
        assert_abs_diff_eq!(b.mean, 0.7, epsilon = 0.01);
        assert_abs_diff_eq!(real::sqrt(a.variance), 0.03, epsilon = 0.005);
        assert_abs_diff_eq!(real::sqrt(b.variance), 0.05, epsilon = 0.01);
    }

    #[test]
    fn the_likelihood_never_falls() {
        let values: Vec<f32> = (0..500).map(|i| unit_f64(3, 4, i) as f32).collect();
        let histogram = Histogram::new(&values);
        let (mut mixture, _) = fit(&histogram, 1);
        mixture.clear();
        for mean in [0.1, 0.15, 0.9] {
            mixture.push(Component { weight: 1.0 / 3.0, mean, variance: 0.01 }).unwrap();
        }
        let mut last = f64::NEG_INFINITY;
        for _ in 0..100 {
            let now = step(&mut mixture, &histogram);
            assert!(now >= last - 1e-9 * now.abs(), "{now} {last}"); // rounding of 500 summands
            last = now;
        }
    }

    #[test]
    fn equal_values_no_values_and_nan_give_numbers() {
        for values in [&[0.3f32; 50][..], &[], &[f32::NAN, 0.5, f32::INFINITY, -1.0]] {
            let histogram = Histogram::new(values);
            for k in 1..=MAX_COMPONENTS {
                let (mixture, _) = fit(&histogram, k);
                assert_eq!(mixture.len(), k);
                assert!(mixture.iter().all(|c| c.mean.is_finite() && c.variance >= VARIANCE_FLOOR && c.weight > 0.0));
            }
        }
        assert_eq!(fit_auto(&Histogram::new(&[0.3; 50])).len(), 1);
    }

    #[test]
    fn posteriors_are_shares_far_from_every_component_too() {
        let c = |mean| Component { weight: 0.5, mean, variance: VARIANCE_FLOOR };
        let mut p = [0.0; MAX_COMPONENTS];
        posterior(&mut p, &[c(0.0), c(1e-3)], 1.0);
        assert!((p[0] + p[1] - 1.0).abs() < 1e-15 && p[1] > 0.99);
    }
}
