//! The maps that a file came with, taken over where they do what is asked: then no cut is added to its seams.
//!
//! A piece that the file's seams leave is taken over where it is a disk, with holes or without, has a UV at every corner, no face turned over (or the
//! whole of it mirrored) and no overlap with itself, and the bound holds: on the mean of all such pieces, or on its own. Each
//! is scaled to its area in space, which packing keeps. Faces without area do not count.
//! Guarantee: what is taken over is moved, mirrored and scaled as a whole, no more. Cost: O(f log f).

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::charts::pieces::Pieces;
use crate::mesh::loops::{border_count, count_loops};
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::search::split::self_overlaps;
use crate::solve::bound::{Strain, flat_area};
use crate::solve::energy::Rest;
use glam::DVec2;

/// Fills `uv` (in the order of the pieces) with `kept_uv`, the file's, and marks in `kept` (one a piece) those that are taken over.
#[allow(clippy::too_many_arguments)]
pub fn take_over(
    uv: &mut [DVec2], // (3 f)
    kept: &mut [u8],  // (pieces)
    pieces: &Pieces,
    working: &Working,
    kept_uv: &[DVec2], // (c), or fewer
    bound: f64,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let corner = |slot: usize| working.corner_source[pieces.source[slot] as usize] as usize;
    let of = |slot: usize| kept_uv.get(corner(slot)).copied().unwrap_or(DVec2::NAN);
    uv.iter_mut().enumerate().for_each(|(slot, uv)| *uv = of(slot));
    let (mut energy, mut area) = (0.0, 0.0); // of all that may be taken over
    let own = scratch.take_filled::<f64>(pieces.count(), f64::INFINITY)?; // mean energy over 4
    for (p, own) in own.iter_mut().enumerate() {
        if !is_flat_shape(pieces, p, scratch.frame())? {
            continue;
        }
        if let Some(fit) = fit(&mut uv[pieces.corners(p)], pieces, p) {
            *own = fit.mean;
            energy += fit.mean * fit.area;
            area += fit.area;
        }
    }
    let all = energy <= bound * area;
    let chart = scratch.take::<u32>(uv.len() / 3)?;
    for (p, kept) in kept.iter_mut().enumerate() {
        *kept = u8::from(own[p].is_finite() && (all || own[p] <= bound));
        let corners = pieces.corners(p);
        chart[corners.start / 3..corners.end / 3].fill(p as u32);
        if *kept == 0 {
            uv[corners].fill(DVec2::ZERO); // no overlap is looked for
        }
    }
    let partner = scratch.take::<u32>(chart.len())?;
    self_overlaps(partner, uv, chart, pieces.count(), |_| true, scratch, workers)?;
    let overlapping = partner.iter().zip(&*chart).filter(|(partner, _)| **partner != NONE);
    overlapping.for_each(|(_, p)| kept[*p as usize] = 0);
    Ok(())
}

/// Whether a plane can hold piece `p`: a sphere with one hole or more.
fn is_flat_shape(pieces: &Pieces, p: usize, mut scratch: Scratch) -> Result<bool, ScratchTooSmall> {
    let surface = pieces.bare_surface(p);
    let done = scratch.take::<u8>(surface.twin.len())?;
    let loops = count_loops(surface.twin, done);
    let edges = (surface.twin.len() + border_count(surface.twin)) / 2;
    Ok(loops > 0 && pieces.vertex_count(p) + surface.mesh.faces.len() + loops == edges + 2)
}

struct KeptFit {
    mean: f64, // of the energy over 4
    area: f64,
}

/// Turns the map of piece `p` face up and scales it so that its energy is least; nothing where a face is turned over.
fn fit(uv: &mut [DVec2], pieces: &Pieces, p: usize) -> Option<KeptFit> {
    let rest = pieces.bare_surface(p).rest;
    let signed: f64 = uv.as_chunks::<3>().0.iter().map(|t| (t[1] - t[0]).perp_dot(t[2] - t[0])).sum();
    if signed < 0.0 {
        uv.iter_mut().for_each(|uv| uv.x = -uv.x);
    }
    let flat = flat_area(rest);
    let is_sound = |(rest, t): (&Rest, &[DVec2; 3])| {
        let [c0, c1] = rest.jacobian(*t);
        let det = c0.perp_dot(c1);
        rest.area <= flat && t.iter().all(|uv| uv.is_finite()) || det > 0.0 && det.is_finite()
    };
    if !rest.iter().zip(uv.as_chunks::<3>().0).all(is_sound) {
        return None;
    }
    let strain = Strain::of(uv, rest);
    let scale = sqrt(sqrt(strain.shrink / strain.stretch));
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    uv.iter_mut().for_each(|uv| *uv *= scale);
    Some(KeptFit { mean: strain.mean(), area: strain.area })
}
