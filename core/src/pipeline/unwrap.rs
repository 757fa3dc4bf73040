//! From polygons to a UV atlas: the one place that joins the stages.

use super::alike::Alike;
use super::exact::{ExactRun, Polishing};
use super::exposure::{expose, share_exposure};
use super::fitting::Fitting;
use super::forced::{Forcing, Layout, Planes, lay_out};
use super::input::{Input, Output};
use super::kept::take_over;
use super::learning::{LearnScene, Learning};
use super::neural::{CutScene, neural};
use super::pieces::slit_pieces;
use super::published::published;
use super::report::{Report, UnwrapError};
use super::settings::{Charts, CountedWork, Packing, Settings, Snap, Stacking, Straighten};
use crate::base::progress::{Progress, Stage, tell};
use crate::base::scratch::{Scratch, bytes_for};
use crate::base::workers::Workers;
use crate::charts::bands::part_bands_need;
use crate::charts::congruence::Likeness;
use crate::charts::copies::{Copies, copies_keep, copies_need};
use crate::charts::halves::part_halves_need;
use crate::charts::pieces::{Pieces, pieces_need};
use crate::finish::fill::{fill_dropped, fill_dropped_need};
use crate::finish::place::{AtlasOutput, Maps, PlaceSummary, Placing, place};
use crate::mesh::frame::to_own_frame;
use crate::mesh::polygons::Counts;
use crate::mesh::repair::{Facing, repair_welding, repair_welding_need};
use crate::mesh::working::Working;
use crate::pack::layout::pack_need;
use crate::plane::overlap::overlaps_need;
use crate::price::cost::{FORBIDDEN, Rates, prices, prices_need};
use crate::price::given::OnMesh;
use crate::rays::bvh::BuildBvh;
use crate::rays::cast::Scene;
use crate::rays::exposure::exposure_need;
use crate::search::budget::Budget;
use crate::search::seams::make_charts_need;
use glam::{DVec2, DVec3};

/// What makes the map.
pub enum Method<'m, 'a> {
    /// Cuts by exposure and distortion, then flattening; no training.
    Exact,
    /// The exact stages' charts, mapped by a network that learned them.
    Neural(&'m mut Fitting<'a>),
    /// Trained maps as published, cut where they tear. They may overlap: the report counts it.
    Published(&'m mut Learning<'a>),
}

impl<'a> Method<'_, 'a> {
    /// The same once more.
    fn again(&mut self) -> Method<'_, 'a> {
        match self {
            Self::Exact => Method::Exact,
            Self::Neural(fitting) => Method::Neural(fitting),
            Self::Published(learning) => Method::Published(learning),
        }
    }
}

/// Scratch bytes that [`unwrap`] asks for: an estimate from above for meshes as they occur. Some mesh may need more (more
/// charts than are foreseen, say): [`unwrap`] then stops with [`UnwrapError::Scratch`], whose figures are those of the
/// slice that was missing, not of the whole. A caller that can find more memory tries again with twice as much, which
/// changes no bit of the result. The same figures again, or a `need` of `usize::MAX`, say that no memory would do.
pub fn unwrap_need(input: &Input, settings: &Settings, bvh: &dyn BuildBvh) -> usize {
    need_for(&input.polygons().counts(), settings, bvh)
}

/// [`unwrap_need`] of a mesh that is not there yet.
pub fn need_for(counts: &Counts, settings: &Settings, bvh: &dyn BuildBvh) -> usize {
    let triangles = counts.triangles;
    let vertices = (counts.vertices.max(triangles) + 64).min(3 * triangles);
    let prices = prices_need(triangles);
    let rays = 3 * bytes_for::<DVec3>(vertices) + Scene::need(triangles, bvh) + exposure_need(settings.rays as usize);
    let pieces = pieces_need(triangles) + make_charts_need(triangles, vertices) + 64 * triangles;
    let packing = pack_need(triangles, triangles.min(CHARTS_FORESEEN), &settings.pack()) + overlaps_need(triangles);
    // What the search falls back to, and what polishing does.
    let last = bytes_for::<DVec2>(3 * triangles) + bytes_for::<u8>(3 * triangles);
    let last = if settings.can_end_early() { last } else { 0 };
    let maps = 18 * 3 * triangles + 4096 + copies_keep(triangles);
    let stages = pieces
        .max(packing + 60 * 3 * triangles)
        .max(copies_need(triangles))
        .max(part_halves_need(triangles))
        .max(3 * triangles + part_bands_need(triangles));
    let originals =
        if settings.stack == Stacking::Off { 0 } else { pieces_need(triangles) + bytes_for::<u32>(3 * triangles) };
    let atlas = last + pieces_need(triangles) + originals + maps + stages;
    repair_welding_need(counts, settings.weld)
        .saturating_add(bytes_for::<DVec3>(vertices) + bytes_for::<f64>(3 * triangles) + bytes_for::<f32>(vertices))
        .saturating_add(rays.max(prices).max(atlas).max(fill_dropped_need(counts)))
}

/// Share of the packing effort where the search had to end early: what is left of the time is little.
const HURRIED: f64 = 0.3;

/// Charts for which [`unwrap_need`] holds packing memory.
const CHARTS_FORESEEN: usize = 4096;

/// Makes the atlas with the exact method.
pub fn unwrap(
    output: Output,
    input: &Input,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Report, UnwrapError> {
    unwrap_by(Method::Exact, output, input, settings, bvh, scratch, workers, progress)
}

/// Makes the atlas by `method`; those that learn take [`super::neural::neural_need`] or [`super::published::published_need`] more bytes.
#[allow(clippy::too_many_arguments)]
pub fn unwrap_by(
    mut method: Method,
    mut output: Output,
    input: &Input,
    settings: &Settings,
    bvh: &dyn BuildBvh,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<Report, UnwrapError> {
    output.fits(input)?;
    match &method {
        Method::Exact => {}
        Method::Neural(fitting) => fitting.check(input.polygons().counts().triangles)?,
        Method::Published(learning) => learning.check()?,
    }
    scratch.require(unwrap_need(input, settings, bvh))?;
    let mut attempt = Attempt { input, settings, bvh, workers, over_diagonals: true };
    let (report, misfolded) = attempt.run(method.again(), output.again(), scratch.frame(), progress)?;

    if misfolded == 0 {
        return Ok(report);
    }
    // A quad that is not convex in UV does not fold over its other diagonal: pieces with such ones stay whole.
    attempt.over_diagonals = false;
    Ok(attempt.run(method, output, scratch, progress)?.0)
}

/// One way through all stages.
struct Attempt<'t> {
    input: &'t Input<'t>,
    settings: &'t Settings,
    bvh: &'t dyn BuildBvh,
    workers: &'t dyn Workers,
    /// Whether pieces are folded whose quads have other diagonals on both sides of the fold.
    over_diagonals: bool,
}

impl Attempt<'_> {
    /// Makes the atlas; how many faces are flipped by folding over diagonals comes with the report.
    fn run(
        &self,
        method: Method,
        output: Output,
        mut scratch: Scratch,
        progress: &mut dyn Progress,
    ) -> Result<(Report, usize), UnwrapError> {
        let Self { input, settings, bvh, workers, .. } = *self;
        let polygons = input.polygons();
        tell(progress, Stage::Repair, 0, 1)?;
        let (mut working, repaired) = repair_welding(&polygons, Facing::Turned, settings.weld, &mut scratch)?;
        let own = scratch.take::<DVec3>(working.positions.len())?;
        let own_frame = to_own_frame(own, working.positions);
        working.positions = own;
        tell(progress, Stage::Repair, 1, 1)?;
        let cost = scratch.take::<f64>(3 * working.faces.len())?;
        let open = scratch.take::<f32>(working.positions.len())?;
        let exposed = expose(open, &working, settings, bvh, scratch.frame(), workers, progress)?;
        share_exposure(output.exposure, open, &working);
        let given = OnMesh::new(input.edges, &polygons, &working);
        let seen = Some(&*open).filter(|_| !matches!(&method, Method::Published(l) if l.is_blind()));
        let Settings { hard_edges, prefer, .. } = *settings;
        let tolerance = (input.tolerance / working.extent).max(repaired.crack_width) * own_frame.scale();
        let breaks = prices(cost, &working, &given, Rates { hard_edges, prefer, tolerance }, seen, scratch.frame())?;
        let mut frame = scratch.frame();
        let forcing = Forcing::new(input, settings, breaks, self.planes());
        let Layout { pieces, closed_breaks, mirror } = lay_out(&working, &given, forcing, cost, &mut frame)?;
        let uv = frame.take::<DVec2>(working.twin.len())?; // in the order of the pieces
        let cut = frame.take::<u8>(working.twin.len())?;
        let budget = budget(settings, input.parts.is_some());
        let kept = frame.take::<u8>(pieces.count())?;
        if let (Method::Exact, Some(kept_uv)) = (&method, input.kept_uv) {
            take_over(uv, kept, &pieces, &working, kept_uv, settings.distortion, frame.frame(), workers)?;
        }
        let vertex = |at: usize| input.corners[working.corner_source[pieces.source[at] as usize] as usize];
        let same = |a: usize, b: usize| vertex(a) == vertex(b);
        let Alike { pieces, copies, stacks } =
            Alike::find(cost, uv, kept, &pieces, &same, tolerance, mirror, settings, &mut frame)?;
        let all_uv = uv;
        let (uv, cut) = (&mut all_uv[..pieces.source.len()], &mut cut[..pieces.source.len()]);
        slit_pieces(cut, &pieces, |p| kept[p] != 0 && !copies.is_copy(p), frame.frame())?;
        let total = pieces.count();
        let open = |c: u32| output.exposure[working.vertex_source[working.mesh().vertex(c) as usize] as usize];
        let scene = LearnScene { pieces: &pieces, kept, open: &open, budget, workers };
        let mends = !matches!(method, Method::Published(_));
        let mut placing = placing(settings, &pieces, copies, &working, input.parts, mends);
        let polishing = polishing(settings, mends && input.kept_uv.is_none(), budget.bulky);
        let mut searched = None;
        let exact = ExactRun { placing: &placing, polishing, budget, kept, workers };
        let is_given = matches!(&method, Method::Neural(fitting) if fitting.is_given);
        if matches!(method, Method::Exact | Method::Neural(_)) && !is_given {
            searched = exact.run_for(settings.work.seams, uv, cut, frame.frame(), progress)?;
        }
        match method {
            Method::Exact => {}
            Method::Neural(fitting) => {
                let scene =
                    CutScene { working: &working, pieces: &pieces, copies, bound: settings.distortion, workers };
                neural(uv, cut, &scene, fitting, frame.frame(), progress)?;
            }
            Method::Published(learning) => published(uv, cut, &scene, learning, frame.frame(), progress)?,
        }
        placing.packing.effort *= if searched.is_some() { HURRIED } else { 1.0 };
        copies.spread(uv, cut, &pieces);
        let forbidden_cuts = pieces.cut_count(cut, |cost| cost >= FORBIDDEN);
        tell(progress, Stage::Seams, total, total)?;
        let out = AtlasOutput { corner_uv: &mut *output.corner_uv, polygon_chart: output.polygon_chart };
        let mut placed = place(out, Maps { uv, cut }, &placing, frame.frame(), workers, progress)?;
        let Output { corner_uv, polygon_chart, .. } = output;
        let (stacked, misfolded) = stacks.lay_on(corner_uv, polygon_chart, &mut placed, all_uv, &working, frame)?;
        fill_dropped(corner_uv, &polygons, &working, scratch)?;
        let ended_early = CountedWork::of([exposed, searched, placed.steps]);
        let PlaceSummary { chart_count, distortion, utilisation, padding, flipped, overlapping, .. } = placed;
        let figures =
            Report { chart_count, distortion, utilisation, padding, flipped, overlapping, ..Report::default() };
        Ok((Report { stacked, forbidden_cuts, closed_breaks, repaired, ended_early, ..figures }, misfolded))
    }

    /// The planes in which pieces are folded; none where nothing is stacked mirrored, or UVs are given that have no such seams.
    fn planes(&self) -> Option<Planes> {
        let Self { input, settings, over_diagonals, .. } = *self;
        let folds = settings.stack == Stacking::Mirrored && input.kept_uv.is_none();
        folds.then(|| Planes { likeness: Likeness::near(true), over_diagonals })
    }
}

/// What is placed, and how.
fn placing<'p>(
    settings: &Settings,
    pieces: &'p Pieces<'p>,
    copies: Copies<'p>,
    working: &'p Working<'p>,
    parts: Option<&'p [u32]>,
    mends: bool,
) -> Placing<'p> {
    let on_texels = (settings.snap == Snap::Texel).then_some(settings.distortion);
    Placing { pieces, copies, working, parts, packing: settings.pack(), steps: settings.work.pack, on_texels, mends }
}

/// What the search may spend.
fn budget(settings: &Settings, has_parts: bool) -> Budget {
    let whole = settings.charts == Charts::One;
    Budget {
        distortion: settings.distortion,
        bulky: whole || has_parts,
        whole,
        renewals: settings.search,
        seed: settings.seed,
        ends_early: settings.can_end_early(),
    }
}

/// What is done to charts after the search, where that `may` be.
fn polishing(settings: &Settings, may: bool, bulky: bool) -> Polishing {
    Polishing {
        straightens: may && settings.straighten != Straighten::Off,
        cuts: may && !bulky && settings.packing == Packing::Tight,
        distortion: settings.distortion,
    }
}
