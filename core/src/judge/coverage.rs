//! Coverage of texels: utilisation, and overlap as a fraction, at a resolution.
//!
//! Scan conversion at texel centres, half-open in x and y: a row belongs to the side that starts at or below it, a
//! column to the span that starts at or before it. A side's crossing with a row is computed from its ends in one order,
//! whichever face it belongs to, so a texel on a side shared by two faces counts once, and none is missed. Rows
//! accumulate differences: cost is the sum of faces' heights in texels, plus the texels.

use super::input::{UvBox, UvMesh};
use crate::base::real::ceil;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use glam::DVec2;

/// Texels by how often they are covered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Texels a side.
    pub resolution: u32,
    /// Texels under one face or more.
    pub covered: u64,
    /// Texels under two faces or more.
    pub overlapped: u64,
    /// Faces over the deepest texel.
    pub max_depth: u32,
}

impl Coverage {
    /// Overlapped texels over covered ones; 0 where nothing is covered.
    pub fn overlap_fraction(&self) -> f64 {
        if self.covered == 0 { 0.0 } else { self.overlapped as f64 / self.covered as f64 }
    }

    /// Covered texels over all texels; 0 without texels.
    pub fn utilisation(&self) -> f64 {
        let texels = self.resolution as u64 * self.resolution as u64;
        if texels == 0 { 0.0 } else { self.covered as f64 / texels as f64 }
    }
}

/// Bytes that [`coverage`] needs: four a texel.
pub const fn coverage_need(resolution: u32) -> usize {
    let side = resolution as usize;
    bytes_for::<i32>(side.saturating_mul(side.saturating_add(1)))
}

/// Covers `resolution`^2 texels with the faces that have UV, after fitting the square on `low` of side `extent` of the
/// UV plane to them. What lies outside of it is clipped away.
pub fn coverage(
    mesh: UvMesh,
    low: DVec2,
    extent: f64,
    resolution: u32,
    mut scratch: Scratch,
) -> Result<Coverage, ScratchTooSmall> {
    scratch.require(coverage_need(resolution))?;
    let side = resolution as usize;
    let steps = scratch.take::<i32>(side.saturating_mul(side.saturating_add(1)))?; // (row, column); depth changes
    for f in mesh.mapped_faces() {
        let texels = mesh.corner_uv[f].map(|uv| (uv - low) / extent * resolution as f64 - DVec2::splat(0.5));
        add_spans(steps, texels, side);
    }
    let mut out = Coverage { resolution, ..Coverage::default() };
    for row in steps.rows(side + 1) {
        let mut depth = 0;
        for step in &row[..side] {
            depth += step;
            out.covered += (depth > 0) as u64;
            out.overlapped += (depth > 1) as u64;
            out.max_depth = out.max_depth.max(depth as u32);
        }
    }
    Ok(out)
}

/// [`coverage`] of the square that just holds all UVs: what a map fills of its own box.
pub fn fitted_coverage(
    mesh: UvMesh,
    uv_box: UvBox,
    resolution: u32,
    scratch: Scratch,
) -> Result<Coverage, ScratchTooSmall> {
    coverage(mesh, uv_box.low, uv_box.extent(), resolution, scratch)
}

/// Marks where each row of texel centres (at integers) enters and leaves the triangle.
fn add_spans(steps: &mut [i32], t: [DVec2; 3], side: usize) {
    let bottom = t[0].y.min(t[1].y).min(t[2].y);
    let top = t[0].y.max(t[1].y).max(t[2].y);
    // `as` saturates: rows below 0 become 0.
    let (first, end) = (ceil(bottom).max(0.0) as usize, (ceil(top).max(0.0) as usize).min(side));
    for row in first..end {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if let Some(x) = crossing(t[i], t[j], row as f64) {
                low = low.min(x);
                high = high.max(x);
            }
        }
        if low < high {
            let column = |x: f64| (ceil(x).max(0.0) as usize).min(side);
            steps[row * (side + 1) + column(low)] += 1;
            steps[row * (side + 1) + column(high)] -= 1;
        }
    }
}

/// Where the side from `p` to `q` crosses row `y`; the same bits from either direction.
fn crossing(p: DVec2, q: DVec2, y: f64) -> Option<f64> {
    let (p, q) = if p.y > q.y || (p.y == q.y && p.x > q.x) { (q, p) } else { (p, q) };
    (p.y <= y && y < q.y).then(|| p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::vec;

    fn cover(faces: &[[DVec2; 3]], resolution: u32) -> Coverage {
        let triangles = vec![[0; 3]; faces.len()];
        let mesh = UvMesh { positions: &[DVec3::ZERO], triangles: &triangles, corner_uv: faces };
        let mut bytes = vec![0; coverage_need(resolution)];
        let uv_box = mesh.uv_box().unwrap();
        let short = bytes.len() - 1;
        assert!(fitted_coverage(mesh, uv_box, resolution, Scratch::new(&mut bytes[..short])).is_err());
        fitted_coverage(mesh, uv_box, resolution, Scratch::new(&mut bytes)).unwrap()
    }

    #[test]
    fn the_two_halves_of_a_square_cover_each_texel_once() {
        let [a, b, c, d] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        for resolution in [0, 1, 2, 7, 64] {
            let coverage = cover(&[[a, b, c], [a, c, d]], resolution);
            assert_eq!((coverage.covered, coverage.overlapped), ((resolution as u64).pow(2), 0));
        }
    }

    #[test]
    fn a_folded_pair_covers_the_fold_twice() {
        let [a, b, c] = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let coverage = cover(&[[a, b, c], [a, c, b]], 16);
        assert_eq!((coverage.covered, coverage.overlapped, coverage.max_depth), (120, 120, 2));
        assert_eq!((coverage.overlap_fraction(), coverage.utilisation()), (1.0, 120.0 / 256.0));
    }

    #[test]
    fn a_fan_around_a_texel_centre_leaves_no_hole() {
        let ring = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let middle = DVec2::new(2.5 / 8.0, 2.5 / 8.0);
        let fan = [0, 1, 2, 3].map(|i| [middle, ring[i], ring[(i + 1) % 4]]);
        let coverage = cover(&fan, 8);
        assert_eq!((coverage.covered, coverage.overlapped), (64, 0));
    }

    #[test]
    fn faces_outside_the_square_are_clipped() {
        let mesh = UvMesh {
            positions: &[DVec3::ZERO],
            triangles: &[[0; 3]; 2],
            corner_uv: &[
                [DVec2::splat(-9.0), DVec2::new(9.0, -9.0), DVec2::splat(9.0)],
                [DVec2::splat(1e300), DVec2::splat(-1e300), DVec2::X],
            ],
        };
        let mut bytes = vec![0; coverage_need(8)];
        let coverage = coverage(mesh, DVec2::ZERO, 1.0, 8, Scratch::new(&mut bytes)).unwrap();
        assert!(coverage.covered >= 28 && coverage.covered <= 64);
    }
}
