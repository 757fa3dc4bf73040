//! Charts onto the square and the grid, with the exact check that no atlas leaves without.
//!
//! Pack, round to the grid, and look there: faces that overlap are split from one another, faces that turned over are set
//! apart, and all is packed anew. After [`SPLITTING`] attempts what still
//! overlaps is set apart as regular polygons. What is measured and reported is what is written.
//! Guarantee: nothing overlaps, or there is an error. Limit: each attempt packs anew, the later ones with less effort.

use super::apart::{mark_turned, set_apart};
use super::order::order_charts;
use super::settle::settle;
use super::snap::{close_slits, packing_step, part_touching, straighten, uv_area};
use super::texels::Texels;
use super::upright::directions;
use crate::base::progress::{Progress, Stage, Stopped, Wish, tell};
use crate::base::real;
use crate::base::scratch::{Alarm, Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::copies::Copies;
use crate::charts::pieces::Pieces;
use crate::charts::surface::Surface;
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::pack::flat_charts::FlatCharts;
use crate::pack::layout::pack;
use crate::pack::placement::Placement;
use crate::pack::settings::{PackSettings, PackSummary};
use crate::plane::grid::{GRID_BITS, GridPoint, GridTriangle};
use crate::plane::overlap::overlaps;
use crate::search::split::{Split, split_overlaps};
use crate::solve::bound::distortion;
use glam::DVec2;

/// Times that an atlas which fails the exact check is split and packed anew.
const ATTEMPTS: usize = 12;
/// Attempts after which polygons that still overlap something are set apart instead.
const SPLITTING: usize = 7;
/// Attempts that are packed with all effort; the others, which knots of slivers need, with [`LATER_EFFORT`] of it: a soup of
/// ten polygons took twelve times the time of one packing.
const CAREFUL: usize = 2;
/// Splits along cheapest paths, one a chart, before charts that overlap are halved.
const CHEAP_SPLITS: usize = 60;
/// See [`CAREFUL`].
const LATER_EFFORT: f64 = 0.05;

/// The maps of all pieces, one entry a corner in the order of the pieces.
pub struct Maps<'m> {
    /// UVs; afterwards those on the grid, in the scale that the charts had.
    pub uv: &'m mut [DVec2],
    /// Cuts.
    pub cut: &'m mut [u8],
}

/// Where the atlas is written.
pub struct AtlasOutput<'o> {
    /// UV of each input corner.
    pub corner_uv: &'o mut [DVec2],
    /// Chart of each input polygon, or `NONE`.
    pub polygon_chart: &'o mut [u32],
}

/// What is placed, and how.
#[derive(Clone, Copy)]
pub struct Placing<'p> {
    /// The pieces whose maps these are.
    pub pieces: &'p Pieces<'p>,
    /// Those that are alike and stay so where a cut is made for packing.
    pub copies: Copies<'p>,
    /// The mesh that fell into pieces.
    pub working: &'p Working<'p>,
    /// Part of each input polygon, by which charts are numbered.
    pub parts: Option<&'p [u32]>,
    /// How charts are packed.
    pub packing: PackSettings,
    /// Improvements at the most, over all attempts.
    pub steps: u64,
    /// The bound on distortion within which straight borders go to the edges of texels, where that is wanted.
    pub on_texels: Option<f64>,
    /// Whether what overlaps is split and packed anew, not only counted.
    pub mends: bool,
}

/// What was reached.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlaceSummary {
    /// Charts in the atlas.
    pub chart_count: usize,
    /// Mean symmetric Dirichlet energy over 4, after the best global scale, of the UVs on the grid.
    pub distortion: f64,
    /// Share of the unit square that charts cover.
    pub utilisation: f64,
    /// Padding that holds, in texels.
    pub padding: f64,
    /// Faces that are not counter-clockwise on the grid.
    pub flipped: usize,
    /// Faces that overlap another on the grid.
    pub overlapping: usize,
    /// Improvements in packing, where that ended early.
    pub steps: Option<u64>,
}

/// Why there is no atlas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlaceError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// The caller asked to stop.
    Stopped,
    /// So many faces overlap another after all attempts.
    Overlap {
        /// Faces that overlap another.
        faces: usize,
    },
}

impl From<ScratchTooSmall> for PlaceError {
    fn from(e: ScratchTooSmall) -> Self {
        PlaceError::Scratch(e)
    }
}

impl From<Stopped> for PlaceError {
    fn from(_: Stopped) -> Self {
        PlaceError::Stopped
    }
}

/// Packs the charts, puts them on the grid, and checks them there exactly; what overlaps is split and packed anew.
pub fn place(
    out: AtlasOutput,
    maps: Maps,
    placing: &Placing,
    scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<PlaceSummary, PlaceError> {
    let Maps { uv, cut } = maps;
    let AtlasOutput { corner_uv, polygon_chart } = out;
    let faces = placing.pieces.rest().len();
    // What is placed is made an atlas; only improvements of the packing may be broken off.
    let alarm = scratch.alarm();
    let mut scratch = scratch.quiet();
    let mut done = PlaceSummary::default();
    let mut steps = StepCount { left: placing.steps, ..StepCount::default() };
    for attempt in 0..ATTEMPTS {
        steps.ask(progress, attempt)?;
        let mut frame = scratch.frame();
        let numbers = Numbers::new(cut, placing, &mut frame)?;
        let along = frame.take::<DVec2>(numbers.charts)?;
        directions(along, uv, cut, numbers.chart, placing.pieces, frame.frame())?;
        settle(uv, numbers.chart, along, frame.frame())?;
        let area = uv_area(uv);
        let packing = PackSettings { steps: steps.left.min(u64::from(u32::MAX)) as u32, ..placing.packing };
        let packed = pack_charts(uv, &numbers, along, area, attempt, &packing, alarm, &mut frame, workers)?;
        steps.count(&packed.summary, progress, attempt)?;
        let grid = frame.take::<GridPoint>(numbers.nodes)?;
        done.flipped = onto_grid(grid, uv, cut, &numbers, &packed, placing, frame.frame())?;
        let triangles = frame.take::<GridTriangle>(faces)?;
        for (t, n) in triangles.iter_mut().zip(numbers.node) {
            *t = n.map(|n| grid[n as usize]);
        }
        let partner = frame.take::<u32>(faces)?;
        tell(progress, Stage::Check, attempt, ATTEMPTS)?;
        done.overlapping = overlaps(partner, triangles, frame.frame(), workers)?;
        write(corner_uv, polygon_chart, grid, &numbers, placing);
        // From here on the UVs are those on the grid: they are what is measured, and where rounding has laid a border over
        // another, they decide where to split.
        for (slot, n) in numbers.node.as_flattened().iter().enumerate() {
            uv[slot] = grid[*n as usize].uv(GRID_BITS) / packed.placement(&numbers, slot).scale.max(1e-300);
        }
        done.chart_count = numbers.charts;
        done.utilisation = packed.summary.utilisation;
        done.padding = packed.summary.padding;
        done.distortion = distortion(uv, placing.pieces.rest());
        if !placing.mends {
            break;
        }
        let failing = frame.take::<u8>(faces)?;
        if done.overlapping + mark_turned(failing, triangles) == 0 {
            break;
        }
        if attempt >= SPLITTING {
            failing.iter_mut().zip(partner.iter()).for_each(|(f, p)| *f |= u8::from(*p != NONE));
        }
        mend(uv, cut, failing, attempt < SPLITTING, area, placing.pieces, frame, workers)?;
    }
    tell(progress, Stage::Check, ATTEMPTS, ATTEMPTS)?;
    done.steps = (steps.left == 0).then_some(steps.done);
    match done.overlapping {
        faces if faces > 0 && placing.mends => Err(PlaceError::Overlap { faces }),
        _ => Ok(done),
    }
}

/// Improvements in packing over all attempts.
#[derive(Default)]
struct StepCount {
    left: u64,
    done: u64,
}

impl StepCount {
    /// Tells the caller that charts are packed, who may want no more improvements.
    fn ask(&mut self, progress: &mut dyn Progress, attempt: usize) -> Result<(), Stopped> {
        match progress.report(Stage::Pack, attempt, ATTEMPTS) {
            Wish::GoOn => {}
            Wish::Finish => self.left = 0,
            Wish::Stop => return Err(Stopped),
        }
        Ok(())
    }

    fn count(&mut self, summary: &PackSummary, progress: &mut dyn Progress, attempt: usize) -> Result<(), Stopped> {
        self.done += u64::from(summary.steps);
        self.left -= u64::from(summary.steps).min(self.left);
        if summary.is_broken {
            self.left = 0;
            return self.ask(progress, attempt);
        }
        Ok(())
    }
}

/// Nodes and charts of all pieces together.
struct Numbers<'f> {
    node: &'f [[u32; 3]], // (f)
    chart: &'f [u32],     // (f) in the order of parts
    nodes: usize,
    charts: usize,
}

impl<'f> Numbers<'f> {
    fn new(cut: &[u8], placing: &Placing, keep: &mut Scratch<'f>) -> Result<Self, ScratchTooSmall> {
        let Placing { pieces, working, parts, .. } = *placing;
        let faces = pieces.rest().len();
        let node = keep.take::<[u32; 3]>(faces)?;
        let chart = keep.take::<u32>(faces)?;
        let (nodes, charts) = number(node, chart, cut, pieces, keep.frame())?;
        if let Some(parts) = parts {
            let polygon = |f: usize| working.polygon[pieces.source[3 * f] as usize / 3] as usize;
            let part = |f: usize| parts.get(polygon(f)).copied().unwrap_or(NONE);
            order_charts(chart, charts, part, |f| pieces.rest()[f].area, keep.frame())?;
        }
        Ok(Self { node, chart, nodes, charts })
    }
}

/// Charts in the square.
struct Packed<'f> {
    placements: &'f [Placement], // (charts)
    /// What packing has not seen of a chart may stick out of the square by so much.
    margin: f64,
    summary: PackSummary,
}

impl Packed<'_> {
    /// That of the chart of corner `slot`.
    fn placement(&self, numbers: &Numbers, slot: usize) -> Placement {
        self.placements[numbers.chart[slot / 3] as usize]
    }
}

/// Packs the charts as they look on a coarse grid, so that the last bits of a UV say nothing; those that have a direction `along`
/// which they stand are turned by quarters only.
#[allow(clippy::too_many_arguments)]
fn pack_charts<'f>(
    uv: &[DVec2],
    numbers: &Numbers,
    along: &[DVec2],
    area: f64,
    attempt: usize,
    asked: &PackSettings,
    alarm: Alarm,
    keep: &mut Scratch<'f>,
    workers: &dyn Workers,
) -> Result<Packed<'f>, ScratchTooSmall> {
    let points = keep.take::<DVec2>(numbers.nodes)?;
    let step = if asked.padding == 0 { 0.0 } else { packing_step(area, asked.size) };
    for (n, u) in numbers.node.as_flattened().iter().zip(uv.iter()) {
        points[*n as usize] = if step > 0.0 { DVec2::from((*u / step).to_array().map(real::round)) * step } else { *u };
    }
    let placements = keep.take_filled::<Placement>(numbers.charts, Placement::IDENTITY)?;
    let upright = keep.take::<u8>(numbers.charts)?;
    upright.iter_mut().zip(along).for_each(|(u, a)| *u = u8::from(*a != DVec2::ZERO));
    let shapes = FlatCharts { uv: points, faces: numbers.node, chart: numbers.chart, count: numbers.charts, upright };
    let share = if attempt < CAREFUL { 1.0 } else { LATER_EFFORT };
    let packing = PackSettings { effort: asked.effort * share, ..*asked };
    let summary = pack(placements, &shapes, &packing, &mut keep.frame().under(alarm), workers)?;
    let margin = step * placements.iter().fold(0.0, |m, p| p.scale.max(m));
    Ok(Packed { placements, margin, summary })
}

/// Share of the square that the charts fill when they are packed with `effort` times the effort asked for.
pub fn pack_now(
    uv: &[DVec2],
    cut: &[u8],
    placing: &Placing,
    effort: f64,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<f64, ScratchTooSmall> {
    let numbers = Numbers::new(cut, placing, &mut scratch)?;
    let asked = PackSettings { effort: placing.packing.effort * effort, ..placing.packing };
    let along = scratch.take::<DVec2>(numbers.charts)?;
    directions(along, uv, cut, numbers.chart, placing.pieces, scratch.frame())?;
    let turned = scratch.take::<DVec2>(uv.len())?;
    turned.copy_from(uv);
    settle(turned, numbers.chart, along, scratch.frame())?;
    let alarm = scratch.alarm();
    let summary = pack_charts(turned, &numbers, along, uv_area(uv), 0, &asked, alarm, &mut scratch, workers)?.summary;
    if summary.is_broken { Err(ScratchTooSmall::ALARM) } else { Ok(summary.utilisation) }
}

/// Rounds the placed charts to the grid; returns how many faces are not counter-clockwise there.
fn onto_grid(
    grid: &mut [GridPoint],
    uv: &[DVec2],
    cut: &[u8],
    numbers: &Numbers,
    packed: &Packed,
    placing: &Placing,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let Placing { pieces, working, .. } = placing;
    let steps = (1u32 << GRID_BITS) as f64;
    let node = numbers.node.as_flattened();
    {
        let mut frame = scratch.frame();
        let placed = frame.take::<DVec2>(grid.len())?;
        let shrink = 1.0 - 2.0 * packed.margin;
        for (slot, n) in node.iter().enumerate() {
            let p = packed.placement(numbers, slot).apply(uv[slot]);
            placed[*n as usize] = (p - DVec2::splat(0.5)) * shrink + DVec2::splat(0.5);
        }
        if let Some(bound) = placing.on_texels {
            let Numbers { node, chart, charts, .. } = *numbers;
            let texels = Texels { size: placing.packing.size, bound, node, chart, rest: pieces.rest() };
            let scale = |k: u32| packed.placements[k as usize].scale * shrink;
            texels.lay(placed, charts, |slot| pieces.is_open(cut, slot), scale, frame)?;
        }
        for (to, p) in grid.iter_mut().zip(placed.iter()) {
            *to = GridPoint::snap(p.min(DVec2::splat(1.0 - 1.0 / steps)), GRID_BITS);
        }
    }
    for p in 0..pieces.count() {
        close_slits(grid, pieces.slits(p, cut, node));
    }
    {
        let mut frame = scratch.frame();
        let vertex = frame.take::<u32>(grid.len())?;
        for (slot, n) in node.iter().enumerate() {
            // One place, though repair may have parted its sheets.
            vertex[*n as usize] = working.vertex_source[working.mesh().vertex(pieces.source[slot]) as usize];
        }
        let slits = (0..pieces.count()).flat_map(|p| pieces.slits(p, cut, node));
        part_touching(grid, numbers.node, numbers.chart, vertex, slits, frame)?;
    }
    straighten(grid, numbers.node, scratch)
}

/// Writes the atlas to the user's corners and polygons.
fn write(corner_uv: &mut [DVec2], polygon_chart: &mut [u32], grid: &[GridPoint], numbers: &Numbers, placing: &Placing) {
    let Placing { pieces, working, .. } = placing;
    for (slot, n) in numbers.node.as_flattened().iter().enumerate() {
        corner_uv[working.corner_source[pieces.source[slot] as usize] as usize] = grid[*n as usize].uv(GRID_BITS);
    }
    polygon_chart.fill(NONE);
    for (f, k) in numbers.chart.iter().enumerate() {
        let working_face = pieces.source[3 * f] / 3;
        polygon_chart[working.polygon[working_face as usize] as usize] = *k;
    }
}

/// Parts with `splits` what overlaps; sets apart what fails.
#[allow(clippy::too_many_arguments)]
fn mend(
    uv: &mut [DVec2],
    cut: &mut [u8],
    failing: &mut [u8], // (f)
    splits: bool,
    area: f64,
    pieces: &Pieces,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let changed = scratch.take::<u8>(failing.len())?;
    for p in 0..pieces.count() {
        let mut inner = scratch.frame();
        let corners = pieces.corners(p);
        let surface = pieces.surface(p, &mut inner)?;
        let (uv, cut) = (&mut uv[corners.clone()], &mut cut[corners.clone()]);
        let range = corners.start / 3..corners.end / 3;
        if splits {
            part_all(cut, &mut changed[range.clone()], uv, &surface, inner.frame(), workers)?;
        }
        let failing = &mut failing[range];
        if failing.contains(&1) {
            set_apart(uv, cut, failing, &surface, area, inner)?;
        }
    }
    Ok(())
}

/// Splits charts of a piece until none overlaps itself: the UVs are those of the grid and stay.
fn part_all(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    changed.fill(1);
    for round in 0.. {
        let how = if round < CHEAP_SPLITS { Split::Cheapest } else { Split::Halves };
        if split_overlaps(cut, changed, uv, surface, how, scratch.frame(), workers)? == 0 || !changed.contains(&1) {
            break;
        }
    }
    Ok(())
}

/// Numbers the nodes and charts of all pieces together; returns how many of each.
fn number(
    node: &mut [[u32; 3]],
    chart: &mut [u32],
    cut: &[u8],
    pieces: &Pieces,
    mut scratch: Scratch,
) -> Result<(usize, usize), ScratchTooSmall> {
    let flat = node.as_flattened_mut();
    let queue = scratch.take::<u32>(chart.len())?;
    let (mut nodes, mut charts) = (0, 0);
    for p in 0..pieces.count() {
        let corners = pieces.corners(p);
        let faces = corners.start / 3..corners.end / 3;
        let surface = pieces.bare_surface(p);
        let more = surface.wedges(&cut[corners.clone()], &mut flat[corners.clone()]);
        flat[corners.clone()].iter_mut().for_each(|n| *n += nodes);
        nodes += more as u32;
        let more = surface.charts(&cut[corners], &mut chart[faces.clone()], &mut queue[faces.clone()]);
        chart[faces].iter_mut().for_each(|k| *k += charts);
        charts += more as u32;
    }
    Ok((nodes as usize, charts as usize))
}
