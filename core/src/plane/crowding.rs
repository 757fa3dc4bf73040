//! How full a square some charts would be packed, from a few figures of their shapes.
//!
//! Fitted to 158 atlases of 2 to 47 charts, each mesh predicted from the others: R^2 .82, mean error .023; the area of convex hulls
//! alone says nothing (R^2 below 0). With A the area of all charts, B the side of the smallest square that holds the largest chart
//! over sqrt A, D the hulls' area less A over A, n charts and P their borders' length over sqrt A:
//!     1 / fill - 1 = .032 + .81 max(0, B^2 - 1.15) + .55 D + .64 / n + .010 P
//! A chart alone is no matter of a fit: its own square is the atlas, and fill is 1 / B^2.

use super::hull::{MOST, hull_area};
use crate::base::real::{cos, sin, sqrt};
use core::f64::consts::FRAC_PI_2;
use glam::DVec2;

/// Places on a chart's border that stand for it.
pub const PLACES: usize = 24;
/// Angles over a quarter turn at which boxes are measured.
const ANGLES: usize = 12;

/// What packing will see of all charts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crowd {
    /// Area of the charts.
    pub area: f64,
    /// Side of the smallest square that holds the largest of them.
    pub largest: f64,
    /// Area of their convex hulls.
    pub hulls: f64,
    /// How many there are.
    pub count: f64,
    /// Length of their borders.
    pub border: f64,
}

impl Crowd {
    /// Takes in a chart of this area by the points of its border; returns its outline.
    pub fn add<I: Iterator<Item = DVec2>>(&mut self, area: f64, border: impl Fn() -> I) -> Outline {
        let (mut count, mut ends, mut length) = (0usize, None, 0.0);
        for p in border() {
            let (first, last) = ends.unwrap_or((p, p));
            length += last.distance(p);
            ends = Some((first, p));
            count += 1;
        }
        let (step, mut left) = (count.div_ceil(PLACES), 0);
        let outline = Outline::new(border().filter(|_| {
            left = if left == 0 { step } else { left } - 1;
            left + 1 == step
        }));
        self.area += area;
        self.hulls += outline.hull().max(area);
        self.largest = self.largest.max(outline.square());
        self.count += 1.0;
        self.border += length + ends.map_or(0.0, |(first, last)| last.distance(first));
        outline
    }

    /// Share of the square that they are expected to fill.
    pub fn fill(&self) -> f64 {
        let area = self.area.max(f64::MIN_POSITIVE);
        if self.count <= 1.0 && self.largest > 0.0 {
            return (area / (self.largest * self.largest)).min(1.0);
        }
        let long = (self.largest * self.largest / area - 1.15).max(0.0);
        let hollow = ((self.hulls - self.area) / area).max(0.0);
        1.0 / (1.032 + 0.81 * long + 0.55 * hollow + 0.64 / self.count.max(1.0) + 0.010 * self.border / sqrt(area))
    }
}

/// A chart's outline by places on its border, [`MOST`] at the most.
pub struct Outline {
    points: heapless::Vec<DVec2, MOST>,
}

impl Outline {
    /// Takes the first [`MOST`] points.
    pub fn new(points: impl Iterator<Item = DVec2>) -> Self {
        let mut kept = heapless::Vec::new();
        for p in points.take(MOST) {
            kept.push(p).ok();
        }
        Self { points: kept }
    }

    /// Area of the convex hull.
    pub fn hull(&self) -> f64 {
        hull_area(self.points.len(), |i| self.points[i])
    }

    /// Side of the smallest square, at some angles, that holds it.
    pub fn square(&self) -> f64 {
        let side = |k: usize| {
            let angle = FRAC_PI_2 * k as f64 / ANGLES as f64;
            let turn = DVec2::new(cos(angle), sin(angle));
            let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for p in self.points.iter().map(|p| turn.rotate(*p)) {
                low = low.min(p);
                high = high.max(p);
            }
            (high - low).max_element()
        };
        if self.points.is_empty() { 0.0 } else { (0..ANGLES).map(side).fold(f64::INFINITY, f64::min) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_square_and_a_diamond_are_held_by_their_own_square() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y));
        let turn = DVec2::new(cos(FRAC_PI_2 / 2.0), sin(FRAC_PI_2 / 2.0));
        for points in [square, square.map(|p| turn.rotate(p))] {
            let outline = Outline::new(points.into_iter());
            assert_abs_diff_eq!(outline.square(), 2.0, epsilon = 1e-12);
            assert_abs_diff_eq!(outline.hull(), 4.0, epsilon = 1e-12);
        }
        assert_eq!((Outline::new(core::iter::empty()).square(), Outline::new(core::iter::empty()).hull()), (0.0, 0.0));
    }

    #[test]
    fn long_hollow_and_lonely_charts_fill_less() {
        let good = Crowd { area: 1.0, largest: 0.8, hulls: 1.1, count: 8.0, border: 12.0 };
        assert!((0.7..0.8).contains(&good.fill()), "{}", good.fill());
        for worse in [
            Crowd { largest: 2.0, ..good },
            Crowd { hulls: 1.8, ..good },
            Crowd { count: 2.0, ..good },
            Crowd { border: 40.0, ..good },
        ] {
            assert!(worse.fill() < good.fill());
        }
        assert!(Crowd::default().fill() > 0.0);
        assert_abs_diff_eq!(Crowd { count: 1.0, largest: 1.25, ..good }.fill(), 0.64, epsilon = 1e-12);
    }
}
