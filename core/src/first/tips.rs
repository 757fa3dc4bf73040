//! Tips of limbs, where a cut has to end if the limb is to be flat (Sheffer, Hart 2002).
//!
//! They are the local maxima of the mean distance to sample points (Hilaga et al. 2001), the samples being each as far as can be
//! from those before. Cost: O(n log n) a sample and a tip.

use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::charts::paths::Paths;
use crate::charts::surface::Surface;
use crate::mesh::view::NONE;

/// Sample points of the mean distance.
const SAMPLES: usize = 8;
/// A tip is the farthest point of all within this share of the largest mean distance.
const TIP_RADIUS: f64 = 0.22;
/// Vertices whose mean distance is nearer than this to the least of their component are in its middle.
const MIDDLE: f64 = 1.12;

/// Marks the tips of each component: at least two on a closed one.
pub(super) fn find_tips(
    tip: &mut [u8],
    component: &[u32],
    count: usize,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = tip.len();
    let mean = scratch.take::<f64>(n)?;
    let mut paths = Paths::new(n, &mut scratch)?;
    measure(mean, tip, component, count, surface, &mut paths, scratch.frame())?;
    let largest = scratch.take::<f64>(count)?;
    let smallest = scratch.take_filled::<f64>(count, f64::INFINITY)?;
    for v in 0..n {
        let k = component[v] as usize;
        largest[k] = largest[k].max(mean[v]);
        smallest[k] = smallest[k].min(mean[v]);
    }
    let order = scratch.take::<u32>(n)?;
    order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
    sort::by(order, |a, b| mean[*b as usize].total_cmp(&mean[*a as usize]).then(a.cmp(b)));
    for v in order.iter() {
        let k = component[*v as usize] as usize;
        let m = mean[*v as usize];
        let is_top = !surface.edges_at(*v).any(|(_, w)| mean[w as usize] > m) && !surface.corners_at(*v).is_empty();
        let radius = TIP_RADIUS * largest[k] / SAMPLES as f64;
        if m >= MIDDLE * smallest[k] && is_top && is_peak(*v, radius, mean, tip, surface, &mut paths) {
            tip[*v as usize] = 1;
        }
    }
    Ok(())
}

/// Writes the sum of the distances from all samples to each vertex, rounded; marks the two ends of a long path in each component.
fn measure(
    mean: &mut [f64],
    tip: &mut [u8],
    component: &[u32],
    count: usize,
    surface: &Surface,
    paths: &mut Paths,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = mean.len();
    let near = scratch.take_filled::<f64>(n, f64::INFINITY)?;
    let far = scratch.take_filled::<u32>(count, NONE)?;
    for v in (0..n as u32).rev() {
        far[component[v as usize] as usize] = v;
    }
    for round in 0..=SAMPLES {
        paths.grow(surface, far.iter().copied(), |c| surface.length(c), |_, _| {});
        if round > 0 {
            for v in 0..n {
                mean[v] += paths.cost[v];
                near[v] = near[v].min(paths.cost[v]);
            }
        }
        // First round: only to start from an end of each component. Then the point farthest from all samples.
        let distance: &[f64] = if round == 0 { paths.cost } else { near };
        far.fill(NONE);
        for v in 0..n {
            let best = &mut far[component[v] as usize];
            let is_farther = |than: u32| for_decision(distance[v]) > for_decision(distance[than as usize]);
            if distance[v].is_finite() && (*best == NONE || is_farther(*best)) {
                *best = v as u32;
            }
        }
        far.iter_mut().for_each(|v| *v = if *v == NONE { 0 } else { *v });
        if round <= 1 {
            // The two ends of a long path.
            far.iter().for_each(|v| tip[*v as usize] = 1);
        }
    }
    mean.iter_mut().for_each(|m| *m = for_decision(*m));
    Ok(())
}

/// Whether no vertex within a radius is farther from the samples than `v`, or a tip already.
fn is_peak(v: u32, radius: f64, mean: &[f64], tip: &[u8], surface: &Surface, paths: &mut Paths) -> bool {
    let mut best = true;
    paths.grow(
        surface,
        core::iter::once(v),
        |c| surface.length(c),
        |w, reached| {
            if reached.cost[w as usize] > radius {
                reached.stop = true;
            } else if mean[w as usize] > mean[v as usize] || (w != v && tip[w as usize] != 0) {
                best = false;
                reached.stop = true;
            }
        },
    );
    best
}
