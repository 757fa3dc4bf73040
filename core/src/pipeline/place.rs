//! Charts onto the square and the grid, with the exact check that no atlas leaves without.
//!
//! Pack, round to the grid, and look there: faces that overlap are split from one another, slits whose sides lie on each
//! other are parted, faces that turned over are set apart, and all is packed anew. After [`SPLITTING`] attempts what still
//! overlaps is set apart as regular polygons. What is measured and reported is what is written.
//! Guarantee: nothing overlaps, or there is an error. Limit: each attempt packs anew, the later ones with less effort.

use super::order::order_charts;
use super::report::{Report, UnwrapError, report};
use super::settings::Settings;
use crate::base::progress::{Progress, Stage};
use crate::base::real;
use crate::base::scratch::Scratch;
use crate::base::workers::Workers;
use crate::charts::pieces::Pieces;
use crate::charts::surface::Surface;
use crate::finish::apart::{mark_turned, set_apart};
use crate::finish::settle::settle;
use crate::finish::snap::{close_slits, mark_rejoined, packing_step, straighten, uv_area};
use crate::first::disks::disks_again;
use crate::first::halving::halve;
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::pack::flat_charts::FlatCharts;
use crate::pack::layout::pack;
use crate::pack::placement::Placement;
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

/// Packs the charts, puts them on the grid, and checks them there exactly; what overlaps is split and packed anew, or with
/// `mends` off only counted.
#[allow(clippy::too_many_arguments)]
pub(super) fn place(
    corner_uv: &mut [DVec2],
    polygon_chart: &mut [u32],
    uv: &mut [DVec2],
    cut: &mut [u8],
    pieces: &Pieces,
    working: &Working,
    parts: Option<&[u32]>,
    settings: &Settings,
    mends: bool,
    done: &mut Report,
    mut scratch: Scratch,
    workers: &dyn Workers,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let faces = working.faces.len();
    let steps = (1u32 << GRID_BITS) as f64;
    for attempt in 0..ATTEMPTS {
        report(progress, Stage::Pack, attempt, ATTEMPTS)?;
        let mut frame = scratch.frame();
        let node = frame.take::<[u32; 3]>(faces)?;
        let chart = frame.take::<u32>(faces)?;
        let (nodes, charts) = number(node, chart, cut, pieces, frame.frame())?;
        if let Some(parts) = parts {
            let polygon = |f: usize| working.polygon[pieces.source[3 * f] as usize / 3] as usize;
            let part = |f: usize| parts.get(polygon(f)).copied().unwrap_or(NONE);
            order_charts(chart, charts, part, |f| pieces.rest()[f].area, frame.frame())?;
        }
        settle(uv, chart, charts, frame.frame())?;
        let points = frame.take::<DVec2>(nodes)?;
        let area = uv_area(uv);
        let step = if settings.padding == 0 { 0.0 } else { packing_step(area, settings.size) };
        for (n, u) in node.as_flattened().iter().zip(uv.iter()) {
            points[*n as usize] =
                if step > 0.0 { DVec2::from((*u / step).to_array().map(real::round)) * step } else { *u };
        }
        let placements = frame.take_filled::<Placement>(charts, Placement::IDENTITY)?;
        let shapes = FlatCharts { uv: points, faces: node, chart, count: charts };
        let mut packing = settings.pack();
        packing.effort *= if attempt < CAREFUL { 1.0 } else { LATER_EFFORT };
        let packed = pack(placements, &shapes, &packing, &mut frame, workers)?;
        let grid = frame.take::<GridPoint>(nodes)?;
        // What packing has not seen of a chart may stick out of the square by so much.
        let margin = step * placements.iter().fold(0.0, |m, p| p.scale.max(m));
        for (slot, n) in node.as_flattened().iter().enumerate() {
            let p = placements[chart[slot / 3] as usize].apply(uv[slot]);
            let p = (p - DVec2::splat(0.5)) * (1.0 - 2.0 * margin) + DVec2::splat(0.5);
            grid[*n as usize] = GridPoint::snap(p.min(DVec2::splat(1.0 - 1.0 / steps)), GRID_BITS);
        }
        for p in 0..pieces.count() {
            close_slits(grid, pieces.slits(p, cut, node.as_flattened()).flatten());
        }
        let flips = straighten(grid, node, frame.frame())?;
        let triangles = frame.take::<GridTriangle>(faces)?;
        for (t, n) in triangles.iter_mut().zip(node.iter()) {
            *t = n.map(|n| grid[n as usize]);
        }
        let partner = frame.take::<u32>(faces)?;
        report(progress, Stage::Check, attempt, ATTEMPTS)?;
        let overlapping = overlaps(partner, triangles, frame.frame(), workers)?;
        for (slot, n) in node.as_flattened().iter().enumerate() {
            corner_uv[working.corner_source[pieces.source[slot] as usize] as usize] = grid[*n as usize].uv(GRID_BITS);
        }
        polygon_chart.fill(NONE);
        for (f, k) in chart.iter().enumerate() {
            let working_face = pieces.source[3 * f] / 3;
            polygon_chart[working.polygon[working_face as usize] as usize] = *k;
        }
        done.chart_count = charts;
        done.utilisation = packed.utilisation;
        done.flipped = flips;
        done.overlapping = overlapping;
        // From here on the UVs are those on the grid: they are what is measured, and where rounding has laid a border over
        // another, they decide where to split.
        for (slot, n) in node.as_flattened().iter().enumerate() {
            uv[slot] = grid[*n as usize].uv(GRID_BITS) / placements[chart[slot / 3] as usize].scale.max(1e-300);
        }
        done.distortion = distortion(uv, pieces.rest());
        if !mends {
            break;
        }
        let failing = frame.take::<u8>(faces)?;
        let turned = mark_turned(failing, triangles);
        let ajar = frame.take::<u8>(faces)?;
        let slits = (0..pieces.count()).flat_map(|p| pieces.slits(p, cut, node.as_flattened()));
        let vertex = frame.take::<u32>(nodes)?;
        for (slot, n) in node.as_flattened().iter().enumerate() {
            vertex[*n as usize] = working.mesh().vertex(pieces.source[slot]);
        }
        let rejoined = mark_rejoined(ajar, grid, node, chart, vertex, slits, frame.frame())?;
        if overlapping + turned + rejoined == 0 {
            break;
        }
        if attempt >= SPLITTING {
            failing.iter_mut().zip(partner.iter()).for_each(|(f, p)| *f |= u8::from(*p != NONE));
        }
        let changed = frame.take::<u8>(faces)?;
        for p in 0..pieces.count() {
            let mut inner = frame.frame();
            let corners = pieces.corners(p);
            let surface = pieces.surface(p, &mut inner)?;
            let (uv, cut) = (&mut uv[corners.clone()], &mut cut[corners.clone()]);
            let range = corners.start / 3..corners.end / 3;
            if ajar[range.clone()].contains(&1) {
                let ajar = &ajar[range.clone()];
                halve(cut, &mut changed[range.clone()], &surface, |f| ajar[f] != 0, inner.frame())?;
                disks_again(cut, &surface, inner.frame())?;
            }
            if attempt < SPLITTING {
                part_all(cut, &mut changed[range.clone()], uv, &surface, inner.frame(), workers)?;
            }
            let failing = &mut failing[range];
            if failing.contains(&1) {
                set_apart(uv, cut, failing, &surface, area, inner)?;
            }
        }
    }
    report(progress, Stage::Check, ATTEMPTS, ATTEMPTS)?;
    if done.overlapping == 0 || !mends { Ok(()) } else { Err(UnwrapError::Overlap { faces: done.overlapping }) }
}

/// Splits charts of a piece until none overlaps itself: the UVs are those of the grid and stay.
fn part_all(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), UnwrapError> {
    for round in 0.. {
        changed.fill(0);
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
) -> Result<(usize, usize), UnwrapError> {
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
