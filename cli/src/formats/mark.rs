//! What tells the parts of a segmented mesh apart in its file.

/// What a file says of the part that a polygon belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mark {
    /// An integer.
    Label(i64),
    /// Red, green and blue, 65535 the brightest.
    Colour([u16; 3]),
}

impl Mark {
    /// Of a colour whose parts are in [0, 1]; what is beyond is cut.
    pub(super) fn colour(rgb: [f64; 3]) -> Self {
        Mark::Colour(rgb.map(|c| (c.clamp(0.0, 1.0) * 65535.0).round() as u16))
    }

    /// The mark that most corners have; the first of those that are as many.
    pub(super) fn of_most(corners: impl Iterator<Item = Mark> + Clone) -> Option<Self> {
        let count = |mark: &Mark| corners.clone().filter(|m| m == mark).count();
        // max_by_key gives the last of equals, so the order is turned.
        let all: Vec<Mark> = corners.clone().collect();
        all.into_iter().rev().max_by_key(count)
    }
}
