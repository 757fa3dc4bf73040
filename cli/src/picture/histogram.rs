//! Exposure of seam vertices against that of all vertices, as shares a bin (heights are their roots),
//! over the exposure ramp.

use super::font;
use super::image::Image;
use crate::base::colour::{self, FAINT, INK, PAPER, SEAM};

const BINS: usize = 25;

/// Shares of `values` a bin over [0, 1]; all 0 where there is no value.
fn shares(values: &[f32]) -> [f32; BINS] {
    let mut bins = [0.0; BINS];
    for value in values {
        bins[((value * BINS as f32) as usize).min(BINS - 1)] += 1.0 / values.len() as f32;
    }
    bins
}

/// The mean; 0 of no value.
pub fn mean(values: &[f32]) -> f64 {
    values.iter().map(|v| *v as f64).sum::<f64>() / values.len().max(1) as f64
}

/// Draws into the rectangle at `at` of `size` pixels.
pub fn draw(image: &mut Image, at: [usize; 2], size: [usize; 2], all: &[f32], seam: &[f32]) {
    image.fill(at, size, PAPER, 1.0);
    let (left, width) = (at[0] + 16, size[0] - 32);
    let (top, bottom) = (at[1] + 60, at[1] + size[1] - 52);
    let (all_share, seam_share) = (shares(all), shares(seam));
    let highest = all_share.iter().chain(&seam_share).fold(0.04f32, |m, s| m.max(*s));
    // Square roots: the open bin would press the others flat.
    let height = |share: f32| ((bottom - top) as f32 * (share / highest).sqrt()) as usize;
    let edge = |bin: usize| left + width * bin / BINS;
    for bin in 0..BINS {
        let (x, w) = (edge(bin) + 1, edge(bin + 1) - edge(bin) - 2);
        let (h, s) = (height(all_share[bin]), height(seam_share[bin]));
        image.fill([x, bottom - h], [w, h], [168, 176, 188], 1.0);
        image.fill([x + w / 4, bottom - s], [w - w / 2, s], SEAM, 0.82);
    }
    image.fill([left, bottom], [width, 2], INK, 1.0);
    for x in 0..width {
        image.fill([left + x, bottom + 6], [1, 10], colour::exposure(x as f32 / width as f32), 1.0);
    }
    for (values, ink) in [(all, FAINT), (seam, SEAM)] {
        if !values.is_empty() {
            let x = left + (mean(values) * width as f64) as usize;
            (top..bottom).step_by(6).for_each(|y| image.fill([x, y], [2, 3], ink, 1.0));
        }
    }
    font::write(image, "EXPOSURE OF VERTICES (SHARE, ROOT SCALE)", [at[0] + 16, at[1] + 14], 2, INK);
    font::write(image, &format!("ALL: MEAN {:.3}", mean(all)), [at[0] + 16, at[1] + 38], 2, FAINT);
    if !seam.is_empty() {
        let text = format!("SEAMS: MEAN {:.3}", mean(seam));
        let x = at[0] + size[0] - 16 - font::width(&text, 2);
        font::write(image, &text, [x, at[1] + 38], 2, SEAM);
    }
    for (text, place) in [("0 HIDDEN", 0), ("1 OPEN", 2)] {
        let x = left + (width - font::width(text, 2)) * place / 2;
        font::write(image, text, [x, bottom + 24], 2, FAINT);
    }
}
