//! Rigid motions, and the one that brings points nearest to others.

use crate::base::real::sqrt;
use glam::DVec2;

/// A rigid motion.
pub struct Motion {
    from: DVec2,
    to: DVec2,
    turn: DVec2,
}

impl Motion {
    /// Leaves everything where it is.
    pub const NONE: Self = Self { from: DVec2::ZERO, to: DVec2::ZERO, turn: DVec2::X };

    /// Where a point goes.
    pub fn apply(&self, p: DVec2) -> DVec2 {
        self.turn.rotate(p - self.from) + self.to
    }

    /// The one that brings points nearest to others; `pairs` answers a point, where it should go, and how much that weighs.
    pub fn fit<I: Iterator<Item = (DVec2, DVec2, f64)>>(pairs: impl Fn() -> I) -> Self {
        let weight: f64 = pairs().map(|s| s.2).sum::<f64>().max(1e-300);
        let from = pairs().map(|(p, _, w)| p * w).sum::<DVec2>() / weight;
        let to = pairs().map(|(_, q, w)| q * w).sum::<DVec2>() / weight;
        let turn = pairs().map(|(p, q, w)| {
            let (p, q) = (p - from, q - to);
            DVec2::new(p.dot(q), p.perp_dot(q)) * w
        });
        let turn = turn.sum::<DVec2>();
        let length = sqrt(turn.dot(turn));
        Self { from, to, turn: if length > 0.0 { turn / length } else { DVec2::X } }
    }

    /// Mean squared distance that is left after it between points and where they should go.
    pub fn gap(&self, pairs: impl Iterator<Item = (DVec2, DVec2, f64)>) -> f64 {
        let (mut sum, mut weight) = (0.0, 1e-300);
        for (p, q, w) in pairs {
            let d = self.apply(p) - q;
            sum += w * d.dot(d);
            weight += w;
        }
        sum / weight
    }
}
