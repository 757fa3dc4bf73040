//! The published segmentation: clusters of shape diameters, their borders moved to creases.
//!
//! Shapira, Shamir, Cohen-Or 2008, with their numbers: smoothed diameters are brought to [0, 1] by
//! (ln(1 + x) - min)/(max - min); a mixture of K Gaussians gives data costs -ln(posterior + 1e-20); two faces with
//! different labels pay -lambda ln(theta/pi + 1e-20) for the angle theta between their normals, a convex one counted as a
//! tenth of it (the minima rule: Hoffman, Richards 1984; the same idea in Golovinskiy, Funkhouser 2008). Then connected
//! regions, small ones absorbed, the majority among neighbours, alike neighbours merged.
//! Limits: an object whose limbs are as thick as its body is one cluster: what `merging` is for.

use super::dual::Dual;
use super::expansion::{Energy, expand, expand_need, fixed};
use super::mixture::{Histogram, MAX_COMPONENTS, fit, fit_auto, posterior};
use super::settings::PartSummary;
use super::surface::PartSurface;
use super::tidy::{absorb, connected, majority, merge_alike, tidy_need};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::mesh::view::NONE;
use core::f64::consts::PI;

/// Rounds of smoothing of the diameters.
const SMOOTHINGS: usize = 2;
/// Keeps logarithms finite.
const TINY: f64 = 1e-20;
/// Share of its angle that a convex edge counts with: 0.08 in CGAL, 0.1 to 0.2 in the literature.
const CONVEX: f64 = 0.1;
/// Rounds of expansion at the most; two are usual.
const ROUNDS: usize = 5;
/// A region of less than this share of the area is no part, nor one of fewer than [`MIN_FACES`].
const MIN_AREA: f64 = 0.002;
/// See [`MIN_AREA`].
const MIN_FACES: usize = 8;
/// Neighbours whose normalised diameters differ by less are one part.
const ALIKE: f64 = 0.03;

/// Bytes that [`published`] takes.
pub const fn published_need(faces: usize) -> usize {
    let edges = faces + faces / 2 + 1;
    2 * bytes_for::<f32>(faces)
        + bytes_for::<i64>(edges)
        + bytes_for::<i64>(faces * MAX_COMPONENTS)
        + max(expand_need(faces, edges), tidy_need(faces))
}

const fn max(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// Labels of `surface` by `clusters` Gaussians (None: by the information criterion) and smoothness `lambda`.
pub fn published(
    labels: &mut [u32],
    surface: &PartSurface,
    dual: &Dual,
    clusters: Option<u32>,
    lambda: f64,
    mut scratch: Scratch,
) -> Result<PartSummary, ScratchTooSmall> {
    let faces = labels.len();
    let value = scratch.take::<f32>(faces)?;
    value.copy_from(surface.diameter);
    smooth(value, surface.twin, dual, &mut scratch)?;
    normalise(value);
    let histogram = Histogram::new(value);
    let mixture = clusters.map_or_else(|| fit_auto(&histogram), |k| fit(&histogram, k as usize).0);
    let k = mixture.len();

    let data = scratch.take::<i64>(faces * k)?; // (f, k)
    let mut share = [0.0; MAX_COMPONENTS];
    for (f, (label, data)) in labels.iter_mut().zip(data.rows_mut(k)).enumerate() {
        posterior(&mut share, &mixture, value[f] as f64);
        *label = (0..k).rev().max_by(|a, b| share[*a].total_cmp(&share[*b])).unwrap_or(0) as u32;
        data.iter_mut().zip(share).for_each(|(d, p)| *d = fixed(-real::ln(p + TINY)));
    }
    let weight = scratch.take::<i64>(dual.sides.len())?;
    for (weight, turn) in weight.iter_mut().zip(dual.turn) {
        let angle = if *turn < 0.0 { -turn } else { CONVEX * turn };
        *weight = fixed(-lambda * real::ln(angle / PI + TINY));
    }
    let cost = |f: u32, l: u32| data[f as usize * k + l as usize];
    expand(labels, &Energy { edges: dual.sides, weight, data: &cost }, k as u32, ROUNDS, scratch.frame())?;

    majority(labels, surface.twin, 2, scratch.frame())?;
    let count = connected(labels, dual, scratch.frame())?;
    let least = MIN_AREA * dual.area.iter().sum::<f64>();
    let count = absorb(labels, count, dual, &|area, faces| area < least || faces < MIN_FACES, scratch.frame())?;
    let parts = merge_alike(labels, count, dual, value, ALIKE, scratch.frame())?;
    Ok(PartSummary { parts, clusters: k })
}

/// Each value becomes the area-weighted mean of itself and its neighbours, [`SMOOTHINGS`] times.
fn smooth(values: &mut [f32], twin: &[u32], dual: &Dual, scratch: &mut Scratch) -> Result<(), ScratchTooSmall> {
    let mut frame = scratch.frame();
    let before = frame.take::<f32>(values.len())?;
    for _ in 0..SMOOTHINGS {
        before.copy_from(values);
        for (f, value) in values.iter_mut().enumerate() {
            let (mut sum, mut weight) = (dual.area[f] * before[f] as f64, dual.area[f]);
            for t in twin[3 * f..3 * f + 3].iter().filter(|t| **t != NONE).map(|t| (t / 3) as usize) {
                sum += dual.area[t] * before[t] as f64;
                weight += dual.area[t];
            }
            if weight > 0.0 {
                *value = (sum / weight) as f32;
            }
        }
    }
    Ok(())
}

/// (ln(1 + x) - min)/(max - min); all 0 where they are equal.
fn normalise(values: &mut [f32]) {
    values.iter_mut().for_each(|x| *x = real::ln(1.0 + *x));
    let low = values.iter().fold(f32::INFINITY, |m, x| if *x < m { *x } else { m });
    let high = values.iter().fold(f32::NEG_INFINITY, |m, x| if *x > m { *x } else { m });
    let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
    values.iter_mut().for_each(|x| *x = (*x - low) * scale);
}
