//! The public face of packing: what goes in, what comes out, and the order of the steps.
//!
//! `Tight` fills a square: the charts that hold most of the area get a start from a bit-mask fill at many turns and go
//! through overlap minimisation in a shrinking square (after Gardeyn, Vanden Berghe, Wauters 2025, with distance fields
//! in place of their circles); the many small ones then fill the gaps. `Grid` gives each chart a cell.
//! Guaranteed for `Tight`: no mirroring, one scale for all, inside [0, 1]^2, charts at least `padding` texels apart (by
//! conservative masks in the fill, by an exact check of border segments after separation; or as far as the summary says
//! where that many charts cannot be), the same bits for any number of threads. Counts bound the work, never a clock.
//! Limits: charts are not cut; two or three large ones may leave a third of the square empty whatever the search does.

use super::fill::{self, Fixed};
use super::{clearance, grid, outline, outline::Outlines, separate, shelf, square};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::Workers;
use glam::DVec2;

/// Up to this many charts are separated together from the start.
const ALL: usize = 16;
/// Up to this many are separated together at the end.
const SEPARATE_MAX: usize = 160;
/// Of more charts the largest lead: they are separated first, and the others fill the gaps that they leave.
const LEAD_MAX: usize = 24;
/// Share of the area that leads (7 atlases of 38 to 473 charts fill .7215 with 24 and 0.9, .7166 with 24 and 0.8, .7162 with
/// 32 and 0.85, .7076 when none lead); where [`LEAD_MAX`] charts hold less than the least share, no chart leads.
const LEAD_SHARE: f64 = 0.9;
const LEAD_LEAST: f64 = 0.65;
/// The square of all charts is at most so much longer than that of those that lead.
const LEAD_ROOM: f64 = 1.2;

/// Texels that are added to the padding, so that rounding UVs to 2^-24 cannot eat it.
const SLACK: f64 = 1e-3;

/// Triangles of flattened charts, in natural scale: one length unit is the same number of texels in each.
#[derive(Clone, Copy)]
pub struct Charts<'a> {
    /// UV vertices.
    pub uv: &'a [DVec2], // (n)
    /// UV vertices of each triangle.
    pub faces: &'a [[u32; 3]], // (f)
    /// Chart of each triangle; triangles of charts at or above `count` are left out.
    pub chart: &'a [u32], // (f)
    /// Number of charts.
    pub count: usize,
}

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
pub struct Settings {
    /// Texture side in texels, at least 1.
    pub size: u32,
    /// Empty texels between two charts. In `Grid`, on each side of a cell.
    pub padding: u32,
    /// Placement.
    pub mode: Mode,
    /// Seed of the search.
    pub seed: u64,
    /// Search work; 1 is the default, 0 only the fill.
    pub effort: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { size: 1024, padding: 2, mode: Mode::Tight, seed: 0, effort: 1.0 }
    }
}

/// Where a chart goes: `scale * turn(p) + translation`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Placement {
    /// Cosine and sine of the rotation.
    pub turn: DVec2,
    /// Where the origin goes.
    pub translation: DVec2,
    /// Scale; the same for all charts in `Tight`.
    pub scale: f64,
}

impl Placement {
    /// Leaves a chart where it is.
    pub const IDENTITY: Placement = Placement { turn: DVec2::X, translation: DVec2::ZERO, scale: 1.0 };

    /// The place of a UV point of the chart.
    #[inline]
    pub fn apply(&self, p: DVec2) -> DVec2 {
        (self.turn.rotate(p) * self.scale + self.translation).clamp(DVec2::ZERO, DVec2::ONE)
    }
}

/// What was reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Share of the unit square that charts cover, by area.
    pub utilisation: f64,
    /// Padding that holds, in texels: the one asked for, unless that many charts could not be kept so far apart.
    pub padding: f64,
}

/// A chart's pose in the square [0, side]^2 of local units: angle, and where its centre is.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Pose {
    pub angle: f64,
    pub at: DVec2,
}

/// Scratch bytes that [`pack`] asks for.
pub fn pack_need(face_count: usize, chart_count: usize, settings: &Settings) -> usize {
    let edges = face_count * 3;
    let fills = fill::need(chart_count).max(fill::need(chart_count.min(LEAD_MAX)));
    let separated = if chart_count <= SEPARATE_MAX { chart_count } else { LEAD_MAX };
    let separation = separate::need(edges, separated) + clearance::need(edges, separated);
    let tight = bytes_for::<Pose>(chart_count) + fills.max(shelf::need(chart_count)).max(separation);
    outline::need(face_count, chart_count) + if settings.mode == Mode::Tight { tight } else { 0 }
}

/// Places every chart in the unit square; `placements` has one entry a chart.
///
/// Charts without faces get a placement that leaves them where they are. Charts without area (needles, points) are kept
/// apart like the others. Coordinates that are not finite count as 0. On an error nothing is written.
/// Cost: O(f log f) for the borders; the fill grows about linearly with charts; separation has a fixed bound.
pub fn pack(
    placements: &mut [Placement],
    charts: &Charts,
    settings: &Settings,
    scratch: &mut Scratch,
    workers: &dyn Workers,
) -> Result<Summary, ScratchTooSmall> {
    debug_assert_eq!(placements.len(), charts.count, "one placement a chart");
    scratch.require(pack_need(charts.faces.len(), charts.count, settings))?;
    let mut frame = scratch.frame();
    let outlines = outline::trace(charts, &mut frame)?;
    if settings.mode == Mode::Grid {
        return Ok(grid::place(placements, &outlines, settings));
    }
    let poses = frame.take::<Pose>(charts.count)?;
    let gap = Gap { texels: settings.padding as f64 + SLACK, size: settings.size.max(1) as f64 };
    let (mut side, padding) = shelf::place(poses, &outlines, &gap, &mut frame)?;
    let kept = if padding >= gap.texels { settings.padding as f64 } else { f64::max(padding - SLACK, 0.0) };
    if padding >= gap.texels {
        let leading = leading(&outlines);
        let lead = outlines.leading(leading);
        let all = leading == outlines.count();
        // Charts that are separated twice get half the work each time.
        let twice = leading > 1 && !all && outlines.count() <= SEPARATE_MAX;
        let settings = Settings { effort: settings.effort * if twice { 0.5 } else { 1.0 }, ..*settings };
        let mut lead_side = side;
        if leading == 1 {
            square::place(&mut poses[..1], &mut lead_side, &lead);
        } else if leading > 1 {
            // Wide enough for the larger square that all charts may need.
            let gap = Gap { texels: gap.texels * if all { 1.0 } else { LEAD_ROOM }, ..gap };
            let poses = &mut poses[..leading];
            fill::improve(poses, &mut lead_side, &lead, Fixed::NONE, &gap, &mut frame, workers)?;
            separate::improve(poses, &mut lead_side, &lead, &gap, &settings, &mut frame, workers)?;
        }
        if !all {
            let fixed = Fixed { charts: leading, room: LEAD_ROOM * lead_side };
            // Charts that lead keep the wider gap only where a step found them a smaller square than the shelf's.
            let found = leading > 0
                && lead_side < side
                && fill::improve(poses, &mut side, &outlines, fixed, &gap, &mut frame, workers)?;
            if !found {
                shelf::place(poses, &outlines, &gap, &mut frame)?;
                fill::improve(poses, &mut side, &outlines, Fixed::NONE, &gap, &mut frame, workers)?;
            }
            if outlines.count() <= SEPARATE_MAX {
                separate::improve(poses, &mut side, &outlines, &gap, &settings, &mut frame, workers)?;
            }
        }
    }
    Ok(finish(placements, poses, &outlines, kept))
}

/// How many of the largest charts lead.
fn leading(outlines: &Outlines) -> usize {
    let (count, total) = (outlines.count(), outlines.area.iter().sum::<f64>());
    let mut sum = 0.0;
    let held = outlines.area.iter().take(LEAD_MAX).take_while(|area| {
        let before = sum;
        sum += **area;
        before < LEAD_SHARE * total
    });
    let held = held.count();
    let share: f64 = outlines.area[..held].iter().sum();
    match count <= ALL {
        true => count,
        false if share >= LEAD_LEAST * total => held,
        false => 0,
    }
}

/// The distance that charts keep: texels of a texture.
#[derive(Clone, Copy)]
pub(super) struct Gap {
    pub texels: f64,
    pub size: f64,
}

impl Gap {
    /// The distance in a square of this side.
    pub fn within(&self, side: f64) -> f64 {
        self.texels / self.size * side
    }
}

/// Fits the charts' common box into the unit square and turns poses into placements.
fn finish(placements: &mut [Placement], poses: &[Pose], outlines: &Outlines, padding: f64) -> Summary {
    let [low, high] = common_box(poses, outlines);
    let side = (high - low).max_element();
    let side = if side > 0.0 { side } else { 1.0 };
    for (chart, out) in placements.iter_mut().enumerate() {
        let chart = outlines.slot[chart] as usize;
        let pose = poses[chart];
        *out = if outlines.edges_of(chart).is_empty() {
            Placement::IDENTITY
        } else {
            let (turn, scale) = (outline::turn(pose.angle), outlines.unit / side);
            let centre = (pose.at - low) / side;
            Placement { turn, translation: centre - turn.rotate(outlines.centre[chart]) * scale, scale }
        };
    }
    let area: f64 = outlines.area.iter().sum();
    Summary { utilisation: area / (side * side), padding }
}

/// Least and largest corner of all charts together.
pub(super) fn common_box(poses: &[Pose], outlines: &Outlines) -> [DVec2; 2] {
    let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    for (chart, pose) in poses.iter().enumerate().filter(|&(i, _)| !outlines.edges_of(i).is_empty()) {
        let [low, high] = outlines.turned_box(chart, outline::turn(pose.angle));
        corners = [corners[0].min(pose.at + low), corners[1].max(pose.at + high)];
    }
    if corners[0].x <= corners[1].x { corners } else { [DVec2::ZERO; 2] }
}
