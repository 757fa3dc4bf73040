//! The public face of packing: what goes in, what comes out, and the order of the steps.
//!
//! `Tight` fills a square: the charts that hold most of the area get a start from a bit-mask fill at many turns and go
//! through overlap minimisation in a shrinking square (after Gardeyn, Vanden Berghe, Wauters 2025, with distance fields
//! in place of their circles); the many small ones then fill the gaps. `Grid` gives each chart a cell.
//! Guaranteed for `Tight`: no mirroring, one scale for all, inside [0, 1]^2 and off its border by `padding` texels (an eighth of
//! it at the most), charts at least as far apart (by conservative masks in the fill, by an exact check of border segments after separation; or as far as the summary says
//! where that many charts cannot be), the same bits for any number of threads. Counts bound the work, never a clock.
//! Charts that stand upright are turned by quarters, but, among many, those that would decide the side of the square (`outline::LONG`).
//! Limits: charts are not cut; two or three large ones may leave a third of the square empty whatever the search does.

use super::fill::{self, Fixed};
use super::flat_charts::FlatCharts;
use super::outline::{Outlines, common_box};
use super::placement::{Gap, Placement, Pose};
use super::settings::{Mode, PackSettings, PackSummary};
use super::{clearance, grid, outline, separate, shelf, square};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
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

/// Texels that are added to the padding, so that rounding cannot eat it: charts are packed as they look on a 16th of a texel
/// (`finish::place`), which moves two borders by a 32nd along each axis at the most, and UVs are rounded to 2^-24.
const SLACK: f64 = 0.09;

/// The border takes this share of the square at the most on each side, where the padding would take more.
const BORDER_MOST: f64 = 0.125;

/// Scratch bytes that [`pack`] asks for.
pub fn pack_need(face_count: usize, chart_count: usize, settings: &PackSettings) -> usize {
    let edges = face_count * 3;
    let fills = fill::need(chart_count).max(fill::need(chart_count.min(LEAD_MAX)));
    let separated = if chart_count <= SEPARATE_MAX { chart_count } else { LEAD_MAX };
    let separation = separate::need(edges, separated) + clearance::need(edges, separated);
    let tight = 2 * bytes_for::<Pose>(chart_count) + fills.max(shelf::need(chart_count)).max(separation);
    outline::need(face_count, chart_count) + if settings.mode == Mode::Tight { tight } else { 0 }
}

/// Places every chart in the unit square; `placements` has one entry a chart.
///
/// Charts without faces get a placement that leaves them where they are. Charts without area (needles, points) are kept
/// apart like the others. Coordinates that are not finite count as 0. On an error nothing is written.
/// Cost: O(f log f) for the borders; the fill grows about linearly with charts; separation has a fixed bound.
pub fn pack(
    placements: &mut [Placement],
    charts: &FlatCharts,
    settings: &PackSettings,
    scratch: &mut Scratch,
    workers: &dyn Workers,
) -> Result<PackSummary, ScratchTooSmall> {
    debug_assert_eq!(placements.len(), charts.count, "one placement a chart");
    // The alarm breaks off improvements alone.
    let alarm = scratch.alarm();
    let mut frame = scratch.frame().quiet();
    frame.require(pack_need(charts.faces.len(), charts.count, settings))?;
    let outlines = outline::trace(charts, &mut frame)?;
    if settings.mode == Mode::Grid {
        return Ok(grid::place(placements, &outlines, settings));
    }
    let poses = frame.take::<Pose>(charts.count)?;
    let border = border_of(settings);
    // The charts fill a square within the border, which has so many texels fewer.
    let size = settings.size.max(1) as f64 * (1.0 - 2.0 * border);
    let gap = Gap { texels: settings.padding as f64 + SLACK, size };
    let (mut side, padding) = shelf::place(poses, &outlines, &gap, &mut frame)?;
    let kept = if padding >= gap.texels { settings.padding as f64 } else { f64::max(padding - SLACK, 0.0) };
    let mut steps = Steps { left: settings.steps, ..Steps::default() };
    let mut is_broken = false;
    if padding >= SLACK {
        let gap = Gap { texels: padding, ..gap };
        let whole = frame.take::<Pose>(charts.count)?;
        whole.copy_from(poses);
        let mut shelves = Shelves { poses, whole, side: &mut side, outlines: &outlines, gap };
        match shelves.improve(&mut steps, settings, &mut frame.under(alarm), workers) {
            Err(e) if e.is_alarm() => {
                is_broken = !steps.ran_out;
                poses.copy_from(whole);
            }
            done => done?,
        }
    }
    let summary = finish(placements, poses, &outlines, border, kept);
    Ok(PackSummary { steps: steps.whole, is_broken, ..summary })
}

/// Improvements that may be made, and that were.
#[derive(Default)]
struct Steps {
    left: u32,
    ran_out: bool,
    done: u32,
    whole: u32, // when all charts last had places
}

impl Steps {
    /// The alarm's error where none may be made any more.
    fn next(&mut self) -> Result<(), ScratchTooSmall> {
        self.ran_out = self.left == 0;
        self.left = self.left.checked_sub(1).ok_or(ScratchTooSmall::ALARM)?;
        self.done += 1;
        Ok(())
    }
}

/// Charts in rows, which are improved on.
struct Shelves<'s> {
    poses: &'s mut [Pose],
    /// Those after the last improvement that left all charts in place.
    whole: &'s mut [Pose],
    side: &'s mut f64,
    outlines: &'s Outlines<'s>,
    gap: Gap,
}

impl Shelves<'_> {
    /// Improves step by step; the alarm's error where steps run out.
    fn improve(
        &mut self,
        steps: &mut Steps,
        settings: &PackSettings,
        frame: &mut Scratch,
        workers: &dyn Workers,
    ) -> Result<(), ScratchTooSmall> {
        let Self { outlines, gap, .. } = *self;
        let leading = leading(outlines);
        let lead = outlines.leading(leading);
        let all = leading == outlines.count();
        // Charts that are separated twice get half the work each time.
        let twice = leading > 1 && !all && outlines.count() <= SEPARATE_MAX;
        let settings = PackSettings { effort: settings.effort * if twice { 0.5 } else { 1.0 }, ..*settings };
        let mut lead_side = *self.side;
        if leading == 1 {
            square::place(&mut self.poses[..1], &mut lead_side, &lead);
        } else if leading > 1 {
            // Wide enough for the larger square that all charts may need.
            let gap = Gap { texels: gap.texels * if all { 1.0 } else { LEAD_ROOM }, ..gap };
            let poses = &mut self.poses[..leading];
            steps.next()?;
            fill::improve(poses, &mut lead_side, &lead, Fixed::NONE, &gap, settings.effort, frame, workers)?;
            if all {
                self.is_whole(steps);
            }
            let poses = &mut self.poses[..leading];
            steps.next()?;
            separate::improve(poses, &mut lead_side, &lead, &gap, &settings, frame, workers)?;
        }
        if !all {
            let fixed = Fixed { charts: leading, room: LEAD_ROOM * lead_side };
            // Charts that lead keep the wider gap only where a step found them a smaller square than the shelf's.
            let (poses, side) = (&mut *self.poses, &mut *self.side);
            steps.next()?;
            let found = leading > 0
                && lead_side < *side
                && fill::improve(poses, side, outlines, fixed, &gap, settings.effort, frame, workers)?;
            if !found {
                shelf::place(poses, outlines, &gap, frame)?;
                fill::improve(poses, side, outlines, Fixed::NONE, &gap, settings.effort, frame, workers)?;
            }
            self.is_whole(steps);
            if outlines.count() <= SEPARATE_MAX {
                steps.next()?;
                separate::improve(self.poses, self.side, outlines, &gap, &settings, frame, workers)?;
            }
        }
        self.is_whole(steps);
        Ok(())
    }

    fn is_whole(&mut self, steps: &mut Steps) {
        self.whole.copy_from(self.poses);
        steps.whole = steps.done;
    }
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

/// Share of the square's side that stays empty at each side of it: what lies there is mixed with the other side where a texture
/// repeats, as between charts where it is made small.
fn border_of(settings: &PackSettings) -> f64 {
    match settings.padding {
        0 => 0.0,
        texels => ((f64::from(texels) + SLACK) / f64::from(settings.size.max(1))).min(BORDER_MOST),
    }
}

/// Fits the charts' common box into the unit square without its `border` and turns poses into placements.
fn finish(placements: &mut [Placement], poses: &[Pose], outlines: &Outlines, border: f64, padding: f64) -> PackSummary {
    let [low, high] = common_box(poses, outlines);
    let side = (high - low).max_element();
    let side = if side > 0.0 { side } else { 1.0 } / (1.0 - 2.0 * border);
    for (chart, out) in placements.iter_mut().enumerate() {
        let chart = outlines.slot[chart] as usize;
        let pose = poses[chart];
        *out = if outlines.edges_of(chart).is_empty() {
            Placement::IDENTITY
        } else {
            let (turn, scale) = (outline::turn(pose.angle), outlines.unit / side);
            let centre = (pose.at - low) / side + DVec2::splat(border);
            Placement { turn, translation: centre - turn.rotate(outlines.centre[chart]) * scale, scale }
        };
    }
    let area: f64 = outlines.area.iter().sum();
    PackSummary { utilisation: area / (side * side), padding, ..PackSummary::default() }
}
