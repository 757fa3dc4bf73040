//! Strips made straight: the side of a cylinder, a pipe, a belt becomes a rectangle where the bound allows.
//!
//! What the search leaves of a strip is bent by what little distortion that spares, and nobody can lay a straight texture on it.
//! Charts with four corners (`charts::strip`) and a side that is not straight are laid on rectangles; each stays one as long as the
//! piece's mean stays within the bound and no face is above the cap, on either diagonal of a quad. Flat faces of the object keep their shape.
//! Guarantee: cuts stay, no chart is flipped, and no bound that held is broken.

use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::pieces::Pieces;
use crate::charts::quads::quads_of;
use crate::charts::strip::{bend, corners};
use crate::charts::surface::Surface;
use crate::charts::work::{Work, work_on};
use crate::solve::bound::{distortion, flat_area, most_distorted};
use crate::solve::piece::Stop;
use crate::solve::quad::Quad;
use glam::{DVec2, DVec3};

/// A side that is straighter than this, over its length, needs nothing.
const STRAIGHT: f64 = 1e-4;
/// Cosine of the turn, 2 degrees, within which all faces of a chart are one flat face of the object.
const FLAT: f64 = 0.9994;
/// Rest for the inside of a rectangle.
const STOP: Stop = Stop { steps: 12, tolerance: 1e-7 };

/// Straightens strips; returns how many. `bound` is that on the mean symmetric Dirichlet energy over 4. Pieces that are marked in
/// `kept` (one a piece; no entry: not marked) stay as they are.
pub fn straighten_strips(
    uv: &mut [DVec2],
    cut: &[u8],
    kept: &[u8],
    pieces: &Pieces,
    bound: f64,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    let mut count = 0;
    for p in (0..pieces.count()).filter(|p| kept.get(*p).is_none_or(|kept| *kept == 0)) {
        let mut frame = scratch.frame();
        let (surface, range) = (pieces.bare_surface(p), pieces.corners(p));
        let (uv, cut) = (&mut uv[range.clone()], &cut[range]);
        let charts = ChartList::new(&surface, cut, &mut frame)?;
        let wanted = frame.take::<u8>(charts.count())?;
        for (k, wanted) in wanted.iter_mut().enumerate() {
            *wanted = u8::from(is_bent_strip(charts.faces_of(k), uv, cut, &surface, frame.frame())?);
        }
        if !wanted.contains(&1) {
            continue;
        }
        let laid = frame.take::<DVec2>(uv.len())?;
        laid.copy_from(uv);
        work_on(laid, &surface, cut, &charts, |k| wanted[k] != 0, Work::Rectangle(STOP), frame.frame(), workers)?;
        for k in (0..charts.count()).filter(|k| wanted[*k] != 0) {
            let faces = charts.faces_of(k);
            let mut frame = frame.frame();
            let triangles = frame.take::<[u32; 3]>(faces.len())?;
            triangles.iter_mut().zip(faces).for_each(|(t, f)| *t = [3 * f, 3 * f + 1, 3 * f + 2]);
            let quads = quads_of(faces, triangles, &surface, cut, &mut frame)?;
            count += usize::from(accept(uv, laid, faces, quads, &surface, bound));
        }
    }
    Ok(count)
}

/// Whether a chart is a strip with a side that is not straight, and no flat face of the object.
fn is_bent_strip(
    faces: &[u32],
    uv: &[DVec2],
    cut: &[u8],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<bool, ScratchTooSmall> {
    let open = || faces.iter().flat_map(|f| 3 * f..3 * f + 3).filter(|c| surface.is_open(cut, *c));
    let (Some(first), count) = (open().next(), open().count()) else { return Ok(false) };
    let border = scratch.take::<DVec2>(count)?;
    let mut steps = 0;
    for (p, c) in border.iter_mut().zip(surface.border(cut, first)) {
        *p = uv[c as usize];
        steps += 1;
    }
    // A chart with a second border has more open edges than the first.
    if steps != count || surface.border(cut, first).nth(count).is_some() || is_flat(faces, surface) {
        return Ok(false);
    }
    Ok(corners(border).is_some_and(|four| bend(border, four) > STRAIGHT))
}

/// Whether the faces lie in one plane in space.
fn is_flat(faces: &[u32], surface: &Surface) -> bool {
    let normal = |f: u32| {
        let [a, b, c] = [3 * f, 3 * f + 1, 3 * f + 2].map(|c| surface.mesh.position(c));
        (b - a).cross(c - a)
    };
    let mean = faces.iter().map(|f| normal(*f)).sum::<DVec3>().normalize_or_zero();
    faces.iter().map(|f| normal(*f)).all(|n| {
        let along = n.dot(mean);
        along > 0.0 && along * along >= FLAT * FLAT * n.length_squared() || n == DVec3::ZERO
    })
}

/// Puts a chart's rectangle in place, if the piece is within the bound with it or no worse than before, and no `quads` (of corners) have
/// their other diagonal above the cap by it, as where a side that is straight now holds three corners of one.
fn accept(uv: &mut [DVec2], laid: &mut [DVec2], faces: &[u32], quads: &[Quad], surface: &Surface, bound: f64) -> bool {
    let (before, flat) = (distortion(uv, surface.rest), flat_area(surface.rest));
    let most = 4.0 * most_distorted(bound);
    let sound = faces.iter().map(|f| *f as usize).all(|f| {
        let energy = surface.rest[f].energy([laid[3 * f], laid[3 * f + 1], laid[3 * f + 2]]);
        energy.is_finite() && (energy <= most || surface.rest[f].area <= flat)
    });
    let is_fine = |quad: &Quad, x: &[DVec2]| {
        quad.across().into_iter().zip(quad.rest).all(|(t, rest)| rest.energy(t.map(|c| x[c as usize])) <= most)
    };
    if !sound || quads.iter().any(|q| is_fine(q, uv) && !is_fine(q, laid)) {
        return false;
    }
    exchange(uv, laid, faces);
    let fits = distortion(uv, surface.rest) <= bound.max(before);
    if !fits {
        exchange(uv, laid, faces);
    }
    fits
}

/// Exchanges the UVs of `faces`.
fn exchange(a: &mut [DVec2], b: &mut [DVec2], faces: &[u32]) {
    for c in faces.iter().flat_map(|f| 3 * *f as usize..3 * *f as usize + 3) {
        core::mem::swap(&mut a[c], &mut b[c]);
    }
}
