//! Bounding boxes in rows: a placement that always exists, for any number of charts.
//!
//! Charts stand upright (width at most height after the better of 0 and 90 degrees), tallest first, in rows of a
//! fixed width; the width grows until rows and columns fill a square. When the padding alone would fill the square it
//! is halved until it does not.

use super::outline::Outlines;
use super::placement::{Gap, Pose};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use glam::DVec2;

/// Side of the square, over that of one of the charts' area, up to which padding may blow it up: what is left is a hundredth of it, or a tenth
/// of the texels a side.
const WIDEST: f64 = 10.0;

/// Bytes that [`place`] takes.
pub(super) fn need(chart_count: usize) -> usize {
    bytes_for::<u32>(chart_count) + bytes_for::<DVec2>(chart_count)
}

/// Poses, the side of the square they fill, and the padding in texels that holds.
pub(super) fn place(
    poses: &mut [Pose],
    outlines: &Outlines,
    gap: &Gap,
    scratch: &mut Scratch,
) -> Result<(f64, f64), ScratchTooSmall> {
    let mut frame = scratch.frame();
    let order = frame.take::<u32>(poses.len())?;
    let sizes = frame.take::<DVec2>(poses.len())?;
    for (chart, size) in sizes.iter_mut().enumerate() {
        let [low, high] = outlines.turned_box(chart, DVec2::X);
        *size = high - low;
        poses[chart].angle = if size.x > size.y { core::f64::consts::FRAC_PI_2 } else { 0.0 };
        *size = DVec2::new(size.min_element(), size.max_element());
        order[chart] = chart as u32;
    }
    sort::by(order, |&a, &b| sizes[b as usize].y.total_cmp(&sizes[a as usize].y).then(a.cmp(&b)));
    let mut side = sizes.iter().fold(1.0, |side: f64, s| side.max(s.max_element()));
    let boxes: f64 = sizes.iter().map(|s| s.x * s.y).sum();
    let most = WIDEST * side.max(sqrt(boxes));
    let (least, mut texels) = (side, gap.texels);
    loop {
        while side <= most {
            if rows(poses, order, sizes, side, texels / gap.size * side) {
                return Ok((side, texels));
            }
            side *= 1.1;
        }
        (side, texels) = (least, 0.5 * texels);
        if texels < 1e-9 {
            rows(poses, order, sizes, f64::INFINITY, 0.0);
            return Ok((sizes.iter().map(|s| s.x).sum::<f64>().max(side), 0.0));
        }
    }
}

/// Fills rows from the bottom; true if they fit the square.
fn rows(poses: &mut [Pose], order: &[u32], sizes: &[DVec2], side: f64, gap: f64) -> bool {
    let (mut corner, mut height) = (DVec2::ZERO, 0.0);
    for &chart in order {
        let size = sizes[chart as usize];
        if corner.x > 0.0 && corner.x + size.x > side {
            corner = DVec2::new(0.0, corner.y + height + gap);
            height = 0.0;
        }
        poses[chart as usize].at = corner + 0.5 * size;
        height = f64::max(height, size.y);
        corner.x += size.x + gap;
        if corner.x - gap > side || corner.y + size.y > side {
            return false;
        }
    }
    true
}
