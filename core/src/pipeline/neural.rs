//! A network's map of the exact stages' charts: learned on the cut surface, mended where it folds, given back.
//!
//! A node of the cut surface has features: its place and normal, which chart it is on, and the values of the chart's slowest waves
//! ([`crate::solve::modes`]), by which the network knows the chart from inside. One network maps all charts, each about its own origin;
//! packing moves them.
//! With the mesh, the cuts and the weights give the map again, to the bit, but for nodes that were [mended](super::mend): those are kept
//! beside them.

use super::decimal::Decimal;
use super::fitting::{FitSummary, Fitting, MOST_CHARTS, OwnFigures, net_of};
use super::mend::{Mending, mend};
use super::nodes::{LearningScene, LearningSet, MOST_NODES, largest_charts, write_features};
use super::pieces::slit_pieces;
use super::report::UnwrapError;
use crate::base::progress::{Progress, Stage, Wish};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::workers::Workers;
use crate::charts::copies::Copies;
use crate::charts::cut_mesh::{CutMesh, cut_mesh_need};
use crate::charts::pieces::Pieces;
use crate::charts::surface::Surface;
use crate::judge::distortion::{Sound, distortion, distortion_need};
use crate::judge::input::{UvMesh, areas};
use crate::learn::chart_net::ChartNet;
use crate::learn::fit::{Fit, FitSettings, TERM_NAMES, fit_need};
use crate::learn::kernels::path::Path;
use crate::learn::tape::distortion::REST;
use crate::learn::tape::gap::JACOBIAN;
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::solve::bound::{Strain, flat_area};
use crate::solve::modes::modes_need;
use crate::solve::relax::relax_need;
use core::fmt::Write;
use glam::{DVec2, DVec3};
use half::f16;

/// Steps between two notes to people.
const NOTE: usize = 100;

/// Where a map is learned.
pub(super) struct CutScene<'s> {
    pub working: &'s Working<'s>,
    pub pieces: &'s Pieces<'s>,
    /// What is a copy has the map of its original, which alone is learned.
    pub copies: Copies<'s>,
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub bound: f64,
    pub workers: &'s dyn Workers,
}

impl CutScene<'_> {
    /// The pieces that are learned.
    fn originals(&self) -> impl Iterator<Item = usize> {
        (0..self.pieces.count()).filter(|p| !self.copies.is_copy(*p))
    }
}

/// Scratch bytes beyond those of the exact method.
pub fn neural_need(triangles: usize, settings: &FitSettings) -> usize {
    let nodes = triangles + 2 * MOST_CHARTS + 64; // disks with a node a vertex
    let net = net_of(settings, MOST_CHARTS);
    let lists = cut_mesh_need(triangles)
        .saturating_mul(2)
        .saturating_add(bytes_for::<DVec2>(4 * nodes))
        .saturating_add(bytes_for::<f32>(net.features + 2).saturating_mul(nodes))
        .saturating_add(2 * bytes_for::<u32>(3 * triangles));
    let seen = (MOST_NODES + 64).min(nodes);
    let training = fit_need(net, seen, triangles.min(2 * MOST_NODES))
        .saturating_add(bytes_for::<f32>(net.features + 2).saturating_mul(seen))
        .saturating_add(bytes_for::<f32>(REST + JACOBIAN + 4).saturating_mul(triangles));
    let waves =
        modes_need(nodes, triangles, relax_need(nodes, triangles, 3 * triangles))
            .saturating_add(bytes_for::<DVec3>(8 * nodes));
    let figures = distortion_need(triangles) + bytes_for::<[DVec2; 12]>(triangles);
    lists.saturating_add(training.max(waves).max(figures).max(net.evaluate_need()))
}

/// Learns a map of the charts that `uv` and `cut` hold (one entry a corner of the pieces), and writes it there; or writes the given
/// map and its cuts.
pub(super) fn neural(
    uv: &mut [DVec2],
    cut: &mut [u8],
    scene: &CutScene,
    fitting: &mut Fitting,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let CutScene { working, pieces, workers, .. } = *scene;
    let corners = working.twin.len();
    let slot = scratch.take_filled::<u32>(corners, NONE)?; // of each corner of the working mesh
    scene.originals().flat_map(|p| pieces.corners(p)).for_each(|at| slot[pieces.source[at] as usize] = at as u32);
    let all_cut = &mut fitting.map.cut[..corners];
    settle_cuts(cut, all_cut, uv, scene, fitting.is_given, scratch.frame())?;
    let mesh = working.mesh();
    let (rest, cost, start, listed) = Default::default();
    let surface = Surface { mesh, twin: working.twin, rest, cost, start, corners: listed, stays_whole: false };
    let charts = &largest_charts(&surface, all_cut, slot, &mut scratch)?;
    let net = net_of(&fitting.settings, charts.count());
    let nodes = charts.node_count();
    let features = scratch.take::<f32>(net.features * nodes)?;
    write_features(features, net, charts, working, scratch.frame(), workers)?;
    let x = scratch.take::<DVec2>(nodes)?;
    if fitting.is_given {
        own_map(x, net, features, fitting, scratch.frame(), workers)?;
        write_given(uv, x, slot, charts, fitting);
        return Ok(());
    }
    let given = scratch.take::<DVec2>(nodes)?;
    given.iter_mut().zip(charts.corner).for_each(|(given, c)| *given = uv[slot[*c as usize] as usize]);
    centre(given, charts);
    fit(net, features, given, charts, working, fitting, scratch.frame(), workers, progress)?;
    let own = scratch.take::<DVec2>(nodes)?;
    own_map(own, net, features, fitting, scratch.frame(), workers)?;
    fitting.summary.own = own_figures(own, charts, working, scratch.frame())?;
    x.iter_mut().zip(own.iter()).for_each(|(x, own)| *x = *own);
    let times = times(pieces, scene.copies, &mut scratch)?;
    mend_learned(x, given, uv, slot, times, charts, scene, scratch.frame())?;
    write_back(uv, x, own, slot, charts, fitting);
    let FitSummary { moved, moved_nodes, .. } = &mut fitting.summary;
    (*moved, *moved_nodes) = moves(x, own, scratch)?;
    let area: f64 = pieces.rest().iter().map(|rest| rest.area).sum();
    moved.iter_mut().for_each(|far| *far /= sqrt(area).max(f64::MIN_POSITIVE));
    fitting.summary.charts = charts.count();
    let learned: u32 = charts.faces.iter().map(|f| times[slot[3 * *f as usize] as usize / 3]).sum();
    fitting.summary.faces = [learned as usize, pieces.rest().len()];
    fitting.summary.nodes = nodes;
    Ok(())
}

/// Writes the cuts of the map to `all_cut`, or takes them from there where it `is_given`; those of the pieces leave disks again.
fn settle_cuts(
    cut: &mut [u8],
    all_cut: &mut [u8],
    uv: &[DVec2],
    scene: &CutScene,
    is_given: bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let pieces = scene.pieces;
    if is_given {
        pieces.source.iter().zip(cut.iter_mut()).for_each(|(c, cut)| *cut = all_cut[*c as usize]);
    } else {
        for p in scene.originals() {
            let slots = pieces.corners(p);
            drop_closed(&mut cut[slots.clone()], &uv[slots], &pieces.bare_surface(p), scratch.frame())?;
        }
        all_cut.fill(1);
        pieces.source.iter().enumerate().for_each(|(at, c)| all_cut[*c as usize] = u8::from(pieces.is_open(cut, at)));
    }
    slit_pieces(cut, pieces, |p| !scene.copies.is_copy(p), scratch)
}

/// Drops the cuts inside charts that the map `uv` does not open: a network would have to learn both of their sides alike.
fn drop_closed(cut: &mut [u8], uv: &[DVec2], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let (chart, queue) = (scratch.take::<u32>(faces)?, scratch.take::<u32>(faces)?);
    surface.charts(cut, chart, queue);
    for c in 0..cut.len() as u32 {
        let is_inside = |t: u32| chart[c as usize / 3] == chart[t as usize / 3];
        if cut[c as usize] != 0 && surface.is_closed(uv, c) && is_inside(surface.twin[c as usize]) {
            surface.set_cut(cut, c, false);
        }
    }
    Ok(())
}

/// Mends the learned map `x` of the nodes, which have places in the map `given` and corners have in `uv`. A shape weighs as often as
/// the mesh has it.
#[allow(clippy::too_many_arguments)]
fn mend_learned(
    x: &mut [DVec2],
    given: &[DVec2],
    uv: &[DVec2],
    slot: &[u32],
    times: &[u32],
    charts: &CutMesh,
    scene: &CutScene,
    scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let CutScene { pieces, bound, workers, .. } = *scene;
    let rest_at = |face: usize| {
        let mut rest = pieces.rest()[face];
        rest.area *= f64::from(times[face]);
        rest
    };
    let rest = |f: u32| rest_at(slot[3 * f as usize] as usize / 3);
    let flat = flat_area(pieces.rest());
    let is_learned = |face: usize| charts.node[pieces.source[3 * face] as usize] != NONE;
    let mut others = Strain::default();
    let counted = |face: &usize| times[*face] > 0 && pieces.rest()[*face].area > flat;
    for face in (0..times.len()).filter(|face| counted(face) && !is_learned(*face)) {
        others.add(&rest_at(face), [0, 1, 2].map(|i| uv[3 * face + i]));
    }
    let mending = Mending { charts, rest: &rest, others, given, bound, workers };
    mend(x, &mending, scratch)
}

/// How many times the mesh has each face, in the order of the pieces: 0 of a copy's.
fn times<'k>(pieces: &Pieces, copies: Copies, keep: &mut Scratch<'k>) -> Result<&'k [u32], ScratchTooSmall> {
    let times = keep.take::<u32>(pieces.rest().len())?;
    let counts = copies.counts(pieces.count(), keep)?;
    for (p, count) in counts.iter().enumerate() {
        let corners = pieces.corners(p);
        times[corners.start / 3..corners.end / 3].fill(*count);
    }
    Ok(times)
}

/// Moves each chart's middle to the origin.
fn centre(x: &mut [DVec2], charts: &CutMesh) {
    for k in 0..charts.count() {
        let chart = &mut x[charts.nodes_of(k)];
        let middle = chart.iter().sum::<DVec2>() / chart.len().max(1) as f64;
        chart.iter_mut().for_each(|x| *x -= middle);
    }
}

/// Trains the network of the map that has `given` at the nodes.
#[allow(clippy::too_many_arguments)]
fn fit(
    net: ChartNet,
    features: &[f32],
    given: &[DVec2],
    charts: &CutMesh,
    working: &Working,
    fitting: &mut Fitting,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<(), ScratchTooSmall> {
    let scene = LearningScene { charts, working, features, width: net.features, given };
    let mut set = LearningSet::new(scene, &mut scratch)?;
    let settings = fitting.settings;
    let total = settings.steps;
    let (path, summary) = (Path::best(), &mut fitting.summary);
    let mut run = Fit::new(net, &set.input(), settings, scratch)?;
    while run.step(path, workers)? {
        if !set.is_whole() {
            set.fill();
            run.look_at(&set.input());
        }
        let sample = *run.last();
        // Spread over the run; a curve that is longer than the run takes every step.
        if sample.step * fitting.curve.len() >= summary.samples * total && summary.samples < fitting.curve.len() {
            fitting.curve[summary.samples] = sample;
            summary.samples += 1;
        }
        if sample.step.is_multiple_of(NOTE) {
            let mut text = heapless::String::<256>::new();
            for (name, value) in TERM_NAMES.iter().zip(sample.terms) {
                // What does not fit is left out.
                let _ = write!(text, " {name} {}", Decimal(value));
            }
            progress.note(format_args!("step {} of {total}:{text}", sample.step));
        }
        if progress.report(Stage::Learn, run.steps(), total) == Wish::Stop {
            summary.was_stopped = true;
            break;
        }
    }
    summary.steps = run.steps();
    let weights = run.weights();
    // As a file keeps them, so that they give the map again.
    let kept = fitting.map.weights[..weights.len()].iter_mut().zip(weights);
    kept.for_each(|(to, w)| *to = f16::from_f32(*w).to_f32());
    Ok(())
}

/// Writes the network's own map.
fn own_map(
    x: &mut [DVec2],
    net: ChartNet,
    features: &[f32],
    fitting: &Fitting,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let q = scratch.take::<f32>(2 * x.len())?;
    let weights = &fitting.map.weights[..net.parameter_count()];
    net.evaluate(q, weights, features, Path::best(), workers, &mut scratch)?;
    x.iter_mut().zip(q.as_chunks::<2>().0).for_each(|(x, q)| *x = DVec2::new(q[0].into(), q[1].into()));
    Ok(())
}

/// Writes the map `x` to the corners, and what of it is not the network's `own` to the corrections.
fn write_back(uv: &mut [DVec2], x: &[DVec2], own: &[DVec2], slot: &[u32], charts: &CutMesh, fitting: &mut Fitting) {
    let corrected = &mut fitting.map.corrected[..slot.len()];
    for (c, (at, node)) in slot.iter().zip(charts.node).enumerate().filter(|(_, (at, _))| **at != NONE) {
        let (uv, node) = (&mut uv[*at as usize], *node as usize);
        if node != NONE as usize {
            *uv = x[node];
        }
        let is_own = node != NONE as usize && x[node] == own[node];
        corrected[c] = if is_own { DVec2::NAN } else { *uv };
    }
}

/// Writes the network's map `x` to the corners, where no other UV is given.
fn write_given(uv: &mut [DVec2], x: &[DVec2], slot: &[u32], charts: &CutMesh, fitting: &Fitting) {
    for (c, at) in slot.iter().enumerate().filter(|(_, at)| **at != NONE) {
        let (corrected, node) = (fitting.map.corrected[c], charts.node[c]);
        // A corner that has neither belongs to another mesh.
        uv[*at as usize] = match corrected.is_finite() {
            true => corrected,
            false if corrected.is_nan() && node != NONE => x[node as usize],
            false => DVec2::ZERO,
        };
    }
}

/// How far nodes were moved from their `own` places: of half of them, of one in twenty, of one in a hundred; and how many were.
fn moves(x: &[DVec2], own: &[DVec2], mut scratch: Scratch) -> Result<([f64; 3], usize), ScratchTooSmall> {
    let far = scratch.take::<f64>(x.len())?;
    far.iter_mut().zip(x.iter().zip(own)).for_each(|(far, (x, own))| *far = (*x - *own).length_squared());
    sort::by(far, |a, b| a.total_cmp(b));
    let at = |share: f64| far.get((share * x.len() as f64) as usize).copied().unwrap_or(0.0);
    let moved = far.iter().filter(|far| **far > 0.0).count();
    Ok(([0.5, 0.95, 0.99].map(|share| sqrt(at(share))), moved))
}

/// Figures of the map `x` as the network gives it.
fn own_figures(
    x: &[DVec2],
    charts: &CutMesh,
    working: &Working,
    mut scratch: Scratch,
) -> Result<OwnFigures, ScratchTooSmall> {
    let faces = working.faces.len();
    let corner_uv = scratch.take_filled::<[DVec2; 3]>(faces, [DVec2::NAN; 3])?;
    for f in charts.faces {
        corner_uv[*f as usize] = charts.nodes_at(*f).map(|node| x[node as usize]);
    }
    let mesh = UvMesh { positions: working.positions, triangles: working.faces, corner_uv };
    let areas = areas(mesh, &mut scratch)?;
    let sound = Sound::of(mesh, areas, mesh.uv_box().map_or(1.0, |uv_box| uv_box.extent()));
    let figures = distortion(mesh, areas, sound, scratch)?;
    let is_flipped = |f: &&u32| areas.uv[**f as usize] <= 0.0 && areas.solid[**f as usize] > sound.solid_floor;
    Ok(OwnFigures {
        distortion: figures.symmetric_dirichlet_finite / 4.0,
        conformality: figures.conformality(),
        equiareality: figures.equiareality(),
        flipped: charts.faces.iter().filter(is_flipped).count(),
    })
}
