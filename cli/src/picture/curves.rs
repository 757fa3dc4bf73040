//! An objective over the steps of a training: a panel for each of its terms, from 0 to its largest value.

use super::font;
use super::image::Image;
use crate::base::colour::{FAINT, INK, PAPER, Rgb};

const PANEL: [usize; 2] = [420, 180];
const GAP: usize = 16;
const HEADER: usize = 48;
const LINE: Rgb = [180, 30, 40];

/// Draws the curves as PNG. The visibility loss is the mean exposure of seams, each vertex weighted by its seam score.
pub fn png(title: &str, terms: &[(&str, Vec<f32>)]) -> Vec<u8> {
    let rows = terms.len().div_ceil(2).max(1);
    let step = [PANEL[0] + GAP, PANEL[1] + GAP];
    let mut image = Image::new(2 * step[0] + GAP, HEADER + rows * step[1], PAPER);
    font::write(&mut image, title, [GAP, 16], 2, INK);
    for (i, (name, values)) in terms.iter().enumerate() {
        let at = [GAP + i % 2 * step[0], HEADER + i / 2 * step[1]];
        let top = values.iter().copied().filter(|v| v.is_finite()).fold(0.0f32, f32::max).max(f32::MIN_POSITIVE);
        let name = match *name {
            "visibility" => "VISIBILITY: EXPOSURE OF SEAMS".into(),
            name => name.to_uppercase(),
        };
        font::write(&mut image, &name, at, 2, INK);
        let last = format!("{:.5}", values.last().copied().unwrap_or(0.0));
        font::write(&mut image, &last, [at[0] + PANEL[0] - font::width(&last, 2), at[1]], 2, FAINT);
        let (low, height) = (at[1] + 24, PANEL[1] - 24);
        image.fill([at[0], low + height - 1], [PANEL[0], 1], FAINT, 1.0);
        image.fill([at[0], low], [1, height], FAINT, 1.0);
        let y = |v: f32| low + ((1.0 - (v / top).clamp(0.0, 1.0)) * (height - 1) as f32) as usize;
        let mut before = values.first().map_or(low, |v| y(*v));
        for x in 0..if values.is_empty() { 0 } else { PANEL[0] } {
            let now = y(values[x * values.len() / PANEL[0]]);
            image.fill([at[0] + x, before.min(now)], [1, before.abs_diff(now) + 2], LINE, 1.0);
            before = now;
        }
    }
    image.png()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_any_length_are_pictures() {
        for count in [0, 1, 2, 999] {
            let values: Vec<f32> = (0..count).map(|step| 1.0 / (step + 1) as f32).collect();
            assert!(png("a", &[("places", values.clone()), ("b", values)]).starts_with(b"\x89PNG"));
        }
    }
}
