//! How far apart charts are kept. O(n log n) for n sides of charts, plus the pairs that are close.

use super::boxes::{BoxTree, around};
use super::distance::{Texels, distance, is_closer};
use super::fault::Fault;
use glam::DVec2;

/// A side on a chart's border.
pub(super) struct Side {
    pub ends: [DVec2; 2],
    pub face: u32,
    pub chart: u32,
    /// What shares its unit square.
    pub square: u32,
}

/// Adds a fault for each side, up to `most` in all, that is closer than `gap` to a side of another chart in its square.
pub(super) fn check(sides: &[Side], gap: Texels, most: usize, faults: &mut Vec<Fault>) {
    let boxes: Vec<_> = sides.iter().map(|side| around(&side.ends)).collect();
    let tree = BoxTree::new(&boxes);
    // Wider by far more than f64 rounds.
    let reach = DVec2::splat(f64::from(gap.padding) / f64::from(gap.size) * (1.0 + 1e-9) + 1e-12);
    for (i, side) in sides.iter().enumerate() {
        if faults.len() >= most {
            return;
        }
        let [low, high] = boxes[i];
        tree.each([low - reach, high + reach], |j| {
            let other = &sides[j];
            let is_pair = i < j && side.chart != other.chart && side.square == other.square;
            let is_fault = is_pair && is_closer(side.ends, other.ends, gap);
            if is_fault {
                let texels = distance(side.ends, other.ends) * f64::from(gap.size);
                faults.push(Fault::Gutter(side.face, other.face, texels));
            }
            is_fault
        });
    }
}
