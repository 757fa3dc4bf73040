//! The box of some points, and the map into it.

use glam::DVec3;

/// The box of some points, and the map that centres it and makes its largest side 1.
pub(super) struct UnitBox {
    pub centre: DVec3,
    pub half: f64, // of the largest side: the side itself may be beyond f64
}

impl UnitBox {
    pub fn new(points: impl Iterator<Item = DVec3>) -> Self {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(start, |(low, high), p| (low.min(p), high.max(p)));
        let (low, high) = (low * 0.5, high * 0.5);
        let half = (high - low).max_element();
        Self { centre: low + high, half: if half > 0.0 { half } else { 1.0 } }
    }

    /// Every step is exact under scaling by a power of two.
    pub fn place(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.half * 0.5
    }
}
