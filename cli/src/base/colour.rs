//! Colours: linear light for shading, 8-bit sRGB for pixels, the palette of charts and the ramp of exposure.

use glam::Vec3;
use seamwright_core::base::real;
use std::sync::LazyLock;

/// 8-bit sRGB.
pub type Rgb = [u8; 3];

/// The ground of pictures.
pub const PAPER: Rgb = [247, 248, 250];
/// The ground of a panel on it.
pub const PANEL: Rgb = [233, 236, 240];
/// Words and lines.
pub const INK: Rgb = [38, 43, 51];
/// Words that matter less.
pub const FAINT: Rgb = [126, 134, 146];
/// Seams.
pub const SEAM: Rgb = [214, 28, 36];

/// Linear light of an sRGB colour.
pub fn linear(colour: Rgb) -> Vec3 {
    static TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| {
        core::array::from_fn(|c| {
            let c = c as f32 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { real::pow((c + 0.055) / 1.055, 2.4) }
        })
    });
    Vec3::from_array(colour.map(|c| TABLE[c as usize]))
}

/// The nearest sRGB colour of linear light; below 0 and above 1 are cut.
pub fn srgb(light: Vec3) -> Rgb {
    light.to_array().map(|c| {
        let c = c.clamp(0.0, 1.0);
        let c = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * real::pow(c, 1.0 / 2.4) - 0.055 };
        (c * 255.0 + 0.5) as u8
    })
}

/// Red, green, blue and opacity of linear light as a screen takes them (sRGB); numbers below 0 and above 1 are cut.
pub fn encoded([r, g, b, a]: [f64; 4]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|c| {
        let c = c.clamp(0.0, 1.0) as f32;
        if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * real::pow(c, 1.0 / 2.4) - 0.055 }
    });
    [r, g, b, a.clamp(0.0, 1.0) as f32]
}

/// Linear light of a colour that a screen takes, and its opacity.
pub fn decoded([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    let light = |c: f32| if c <= 0.04045 { c / 12.92 } else { real::pow((c + 0.055) / 1.055, 2.4) };
    [light(r), light(g), light(b), a]
}

/// Linear light of the `i`-th chart: hues a golden angle apart, in three shades.
pub fn chart(i: u32) -> Vec3 {
    let hue = (0.58 + 0.618_034 * i as f32).fract();
    let (saturation, value) = [(0.50, 0.92), (0.62, 0.78), (0.34, 0.97)][i as usize % 3];
    linear(from_hue(hue, saturation, value))
}

/// sRGB of the `i`-th part: the palette of charts.
pub fn part(i: u32) -> Rgb {
    srgb(chart(i))
}

/// sRGB of hue, saturation and value in [0, 1].
pub fn from_hue(hue: f32, saturation: f32, value: f32) -> Rgb {
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|shift| {
        let distance = ((hue + shift).fract() * 6.0 - 3.0).abs() - 1.0;
        let c = value * (1.0 - saturation * (1.0 - distance.clamp(0.0, 1.0)));
        (c * 255.0 + 0.5) as u8
    })
}

/// Exposure from dark violet (0) over teal to pale yellow (1).
pub fn exposure(e: f32) -> Rgb {
    const STOPS: [[f32; 3]; 6] = [
        [38.0, 12.0, 64.0],
        [66.0, 48.0, 130.0],
        [42.0, 104.0, 146.0],
        [38.0, 155.0, 137.0],
        [139.0, 203.0, 95.0],
        [252.0, 236.0, 150.0],
    ];
    let at = e.clamp(0.0, 1.0) * 5.0; // NaN stays NaN and gives the first stop
    let i = (at as usize).min(4);
    core::array::from_fn(|k| (STOPS[i][k] + (STOPS[i + 1][k] - STOPS[i][k]) * (at - i as f32)) as u8)
}
