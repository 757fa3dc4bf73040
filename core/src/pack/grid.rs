//! One cell of a square grid a chart: G = ceil(sqrt K), s = (1 - 2 pad)/G, t = ((c + pad)/G, (r + pad)/G).
//!
//! Row-major; each chart's box is fitted uniformly into the unit square, its least corner at the origin, and then goes
//! to its cell by T(u) = s u + t. `pad` is the padding as a share of a cell, at most 0.45.

use super::outline::Outlines;
use super::placement::Placement;
use super::settings::{PackSettings, PackSummary};
use core::num::NonZero;
use glam::DVec2;

/// Largest share of a cell that padding may take on each side.
const PAD_MAX: f64 = 0.45;

/// Places chart i in cell (i mod G, i div G).
pub(super) fn place(placements: &mut [Placement], outlines: &Outlines, settings: &PackSettings) -> PackSummary {
    let count = outlines.count();
    let side =
        (1..).filter_map(NonZero::<usize>::new).find(|g| g.get() * g.get() >= count).unwrap_or(NonZero::<usize>::MIN);
    let cells = side.get() as f64;
    let pad = (settings.padding as f64 * cells / settings.size.max(1) as f64).min(PAD_MAX);
    let mut covered = 0.0;
    for (chart, out) in placements.iter_mut().enumerate() {
        let cell = DVec2::new((chart % side) as f64, (chart / side) as f64);
        let slot = outlines.slot[chart] as usize;
        let [low, high] = outlines.turned_box(slot, DVec2::X);
        let size = (high - low).max_element();
        let fit = if size > 0.0 { (1.0 - 2.0 * pad) / cells / size } else { 0.0 };
        let corner = outlines.centre[slot] + low / outlines.unit;
        let scale = if fit > 0.0 { fit * outlines.unit } else { 1.0 / cells };
        *out = Placement { turn: DVec2::X, translation: (cell + pad) / cells - corner * scale, scale };
        covered += outlines.area[slot] * fit * fit;
    }
    PackSummary { utilisation: covered, padding: 2.0 * pad / cells * settings.size as f64, ..PackSummary::default() }
}
