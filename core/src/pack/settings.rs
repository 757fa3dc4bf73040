//! What can be asked of packing, and what it reached.

/// How charts are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Equal texel density, free rotation, shapes in one another's gaps.
    #[default]
    Tight,
    /// One cell of a square grid a chart, each chart scaled to its cell.
    Grid,
}

/// What the caller can ask for.
#[derive(Clone, Copy, Debug)]
pub struct PackSettings {
    /// Texture side in texels, at least 1.
    pub size: u32,
    /// Empty texels between two charts, and between charts and the border of the square. In `Grid`, on each side of a cell.
    pub padding: u32,
    /// Placement.
    pub mode: Mode,
    /// Seed of the search.
    pub seed: u64,
    /// Search work; 1 is the default, 0 only the fill.
    pub effort: f64,
    /// Improvements on rows of boxes at the most: fills and separations. 0 leaves the rows.
    pub steps: u32,
}

/// Effort up to which charts are only sketched: the outcome of a trial is compared, and nobody sees it.
const SKETCHED: f64 = 0.15;

/// Whether a packing of this effort is a sketch.
pub(super) fn is_sketch(effort: f64) -> bool {
    effort > 0.0 && effort <= SKETCHED
}

impl Default for PackSettings {
    fn default() -> Self {
        Self { size: 1024, padding: 2, mode: Mode::Tight, seed: 0, effort: 1.0, steps: u32::MAX }
    }
}

/// What was reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PackSummary {
    /// Share of the unit square that charts cover, by area.
    pub utilisation: f64,
    /// Padding that holds, in texels: the one asked for, unless that many charts could not be kept so far apart.
    pub padding: f64,
    /// Improvements that count: [`PackSettings::steps`] of so many gives the same placements.
    pub steps: u32,
    /// Whether the alarm broke off a further one.
    pub is_broken: bool,
}
