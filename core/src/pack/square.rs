//! A chart alone: the turn whose bounding box has the shortest longer side.
//!
//! The longer side of a turned convex hull is piecewise smooth in the angle; a scan of 720 turns in a quarter circle
//! and a golden-section search around the best one find its minimum to 1e-9 of a turn.

use super::outline::{self, Outlines};
use super::placement::Pose;
use core::f64::consts::FRAC_PI_2;
use glam::DVec2;

const SCAN: usize = 720;

/// Turns a single chart (one that has faces, where the others have none) into its smallest square.
pub(super) fn place(poses: &mut [Pose], side: &mut f64, outlines: &Outlines) {
    let mut with_faces = (0..poses.len()).filter(|&i| !outlines.edges_of(i).is_empty());
    let (Some(chart), None) = (with_faces.next(), with_faces.next()) else { return };
    if outlines.upright[chart] != 0 {
        let [low, high] = outlines.turned_box(chart, DVec2::X);
        (poses[chart], *side) = (Pose { angle: 0.0, at: -low }, (high - low).max_element());
        return;
    }
    let extent = |angle: f64| {
        let [low, high] = outlines.turned_box(chart, outline::turn(angle));
        (high - low).max_element()
    };
    let step = FRAC_PI_2 / SCAN as f64;
    let best = (0..SCAN).min_by(|&a, &b| extent(a as f64 * step).total_cmp(&extent(b as f64 * step))).unwrap_or(0);
    let (mut low, mut high) = ((best as f64 - 1.0) * step, (best as f64 + 1.0) * step);
    for _ in 0..48 {
        let (a, b) = (high - (high - low) * 0.618_033_988_749_895, low + (high - low) * 0.618_033_988_749_895);
        if extent(a) <= extent(b) { high = b } else { low = a }
    }
    let angle = [best as f64 * step, 0.5 * (low + high)].into_iter().min_by(|a, b| extent(*a).total_cmp(&extent(*b)));
    let angle = angle.unwrap_or(0.0);
    let [least, _] = outlines.turned_box(chart, outline::turn(angle));
    poses[chart] = Pose { angle, at: -least };
    *side = extent(angle);
}
