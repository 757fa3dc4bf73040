//! Seam optimisation: one budget of distortion, spent where it hides most.
//!
//! From the least cuts that make disks with all tips on their borders, cuts grow along cheapest paths towards what is
//! still too distorted (top-down, against OptCuts' and the greedy gluing of many charts: Li et al. 2018). Each round opens
//! its slits by a few Newton steps from the map before it, so no map is ever flipped. Charts that overlap themselves are
//! split where it costs least, bulky ones where it saves most of the square, and small ones are glued where they fit.
//! Large pieces are cut by way of a decimated mesh.
//! Guarantee: disks, no flips; no overlap inside a chart where splitting ends within its rounds.
//! Limits: slits are not zipped again, and paths slide only while they are carried over from a decimated mesh.

use super::charts::{Charts, Work, job_need, work_on};
use super::compact::{compact_need, split_bulky};
use super::cut::{Paths, cut_to_disks, disks_again};
use super::energy::Rest;
use super::glue::{glue_need, glue_small};
use super::proxy::{proxy_costs, proxy_costs_need};
use super::relax::Stop;
use super::slide::Slides;
use super::split::split_overlaps;
use super::surface::Surface;
use super::transfer::{transfer, transfer_need};
use crate::base::real::{for_decision, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::Workers;
use crate::mesh::collapse::Collapse;
use crate::mesh::decimate::{decimate, decimate_need};
use crate::mesh::overlap::overlaps_need;
use crate::mesh::topology::twins;
use crate::mesh::view::{MeshView, next};
use glam::{DVec2, DVec3};

/// What the search may spend.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub distortion: f64,
    /// Whether a piece should stay one chart where that can be.
    pub one: bool,
}

/// Why the search ended without charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeamError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// The callback asked to stop.
    Stopped,
}

impl From<ScratchTooSmall> for SeamError {
    fn from(e: ScratchTooSmall) -> Self {
        SeamError::Scratch(e)
    }
}

/// Pieces of more faces are cut by way of a decimated mesh. Nefertiti (100k faces): 10k finds shorter seams than the full
/// mesh in a twentieth of the time; 5k to 20k differ by less than two neighbouring seeds of the search.
const PROXY_FROM: usize = 30_000;
/// Faces of that mesh.
const PROXY_FACES: usize = 10_000;
/// How far paths may slide while they are carried over.
const SLIDES: Slides = Slides { reach: 2.0, rounds: 3 };
/// Share of the distortion budget that cuts may leave unspent no longer: with 1, area distortion alone passes 0.1 on the
/// mean of 12 meshes; see docs/RESULTS.md.
const SPEND: f64 = 0.9;
/// Added to every edge length of a rest shape, in units of the mesh's largest side: gives flat faces a shape.
pub const MOLLIFY: f64 = 1e-9;
/// A face below this share of the mean area has none to speak of.
pub const FLAT: f64 = 1e-9;
/// Paths that a round of extension adds at the most: more where the distortion is above the goal by more than [`FAR`] times
/// what the goal allows, so that tight bounds are reached within the rounds.
const PATHS: usize = 3;
/// See [`PATHS`].
const PATHS_FAR: usize = 8;
/// See [`PATHS`].
const FAR: f64 = 5.0;
/// Rounds of extension at the most; each adds paths where the distortion is worst.
const ROUNDS: usize = 80;
/// Times that charts which rounding has flipped are halved: 2^24 faces end as single polygons.
const HALVINGS: usize = 26;
/// Rounds of splitting bulky charts.
const COMPACTIONS: usize = 12;
/// Rounds of gluing, each followed by splitting what then overlaps.
const GLUINGS: usize = 2;
/// Rounds of splitting at the most.
const SPLITS: usize = 60;
/// Newton steps of a round: the map need not be at rest before the next cut is chosen.
const ROUND_STOP: Stop = Stop { steps: 5, tolerance: 1e-4 };
/// Below this share of the distortion before, a full relaxation has found charts that were far from rest.
const AT_REST: f64 = 0.99;
/// Newton steps of the first flattening.
const FIRST_STOP: Stop = Stop { steps: 60, tolerance: 1e-3 };

/// Scratch bytes that [`make_charts`] asks for.
pub fn make_charts_need(faces: usize, vertices: usize) -> usize {
    let corners = 3 * faces;
    let lists = bytes_for::<u8>(faces) + 3 * bytes_for::<u32>(faces + 2);
    let growing = 12 * bytes_for::<f64>(vertices) + 12 * bytes_for::<u32>(vertices) + bytes_for::<[u64; 2]>(corners);
    let splitting = 10 * bytes_for::<u32>(faces) + 12 * bytes_for::<u32>(corners) + 24 * faces + overlaps_need(faces);
    let jobs = 4 * bytes_for::<u32>(corners) + job_need(faces);
    let direct = lists + growing.max(splitting).max(jobs).max(glue_need(faces)).max(compact_need(faces));
    if faces <= PROXY_FROM {
        return direct;
    }
    let coarse = 2 * PROXY_FACES;
    let kept = bytes_for::<Collapse>(vertices) + 600 * coarse;
    let full = bytes_for::<[u32; 3]>(faces) + bytes_for::<u32>(vertices) + decimate_need(vertices, faces);
    let search = make_charts_need(PROXY_FROM, coarse);
    let carry = transfer_need(vertices, faces).max(proxy_costs_need(vertices, coarse));
    direct.max(kept + full.max(search).max(carry))
}

/// Cuts and flattens the surface: writes `cut` (one flag a half-edge) and `uv` (one point a corner).
pub fn make_charts(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    proceed: &mut dyn FnMut() -> bool,
) -> Result<(), SeamError> {
    let faces = surface.mesh.faces.len();
    let large = faces > PROXY_FROM;
    if !large || !cut_by_proxy(cut, surface, budget, scratch.frame(), workers, proceed)? {
        cut.fill(0);
        cut_to_disks(cut, surface, scratch.frame())?;
    }
    flatten(uv, cut, surface, scratch.frame(), workers)?;
    let changed = scratch.take::<u8>(faces)?;
    let compact = !large && !budget.one;
    if compact {
        part_bulky(uv, cut, changed, surface, scratch.frame(), workers, proceed)?;
    }
    let goal = 1.0 + SPEND * (budget.distortion - 1.0);
    for _ in 0..ROUNDS {
        if !proceed() {
            return Err(SeamError::Stopped);
        }
        let now = distortion(uv, surface.rest);
        if now <= goal {
            break;
        }
        changed.fill(0);
        let paths = if now - 1.0 > FAR * (goal - 1.0) { PATHS_FAR } else { PATHS };
        if extend(cut, changed, uv, surface, paths, 0.5, scratch.frame())? == 0 {
            // Nothing is left to cut: what is distorted may only be far from rest.
            changed.fill(1);
            relax_changed(uv, cut, changed, surface, FIRST_STOP, scratch.frame(), workers)?;
            if distortion(uv, surface.rest) > AT_REST * now {
                break;
            }
            continue;
        }
        relax_changed(uv, cut, changed, surface, ROUND_STOP, scratch.frame(), workers)?;
    }
    part_overlaps(uv, cut, changed, surface, scratch.frame(), workers, proceed)?;
    if compact {
        part_bulky(uv, cut, changed, surface, scratch.frame(), workers, proceed)?;
    }
    for _ in 0..GLUINGS {
        changed.fill(0);
        if glue_small(uv, cut, changed, surface, budget.one, scratch.frame())? == 0 {
            break;
        }
        relax_changed(uv, cut, changed, surface, ROUND_STOP, scratch.frame(), workers)?;
        part_overlaps(uv, cut, changed, surface, scratch.frame(), workers, proceed)?;
    }
    Ok(())
}

/// Splits charts until none is bulky or overlaps itself.
fn part_bulky(
    uv: &mut [DVec2],
    cut: &mut [u8],
    changed: &mut [u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
    proceed: &mut dyn FnMut() -> bool,
) -> Result<(), SeamError> {
    for _ in 0..COMPACTIONS {
        changed.fill(0);
        if split_bulky(cut, changed, uv, surface, scratch.frame())? == 0 {
            break;
        }
        relax_changed(uv, cut, changed, surface, ROUND_STOP, scratch.frame(), workers)?;
    }
    part_overlaps(uv, cut, changed, surface, scratch, workers, proceed)
}

/// Splits charts until none overlaps itself.
fn part_overlaps(
    uv: &mut [DVec2],
    cut: &mut [u8],
    changed: &mut [u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
    proceed: &mut dyn FnMut() -> bool,
) -> Result<(), SeamError> {
    for _ in 0..SPLITS {
        if !proceed() {
            return Err(SeamError::Stopped);
        }
        changed.fill(0);
        if split_overlaps(cut, changed, uv, surface, scratch.frame())? == 0 {
            break;
        }
        relax_changed(uv, cut, changed, surface, ROUND_STOP, scratch.frame(), workers)?;
    }
    Ok(())
}

/// Finds the cuts on a decimated mesh and carries them over; false where that would cut a forbidden edge or change the
/// number of charts, so that the search has to begin on the mesh itself.
fn cut_by_proxy(
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    proceed: &mut dyn FnMut() -> bool,
) -> Result<bool, SeamError> {
    let (n, count) = (surface.mesh.positions.len(), surface.mesh.faces.len());
    let history = scratch.take::<Collapse>(n)?;
    // The coarse mesh is copied out of full-size memory, which is then free again.
    let coarse_faces = scratch.take::<[u32; 3]>(2 * PROXY_FACES)?;
    let vertex = scratch.take::<u32>(2 * PROXY_FACES)?;
    let done = {
        let mut frame = scratch.frame();
        let (full_faces, full_vertex) = (frame.take::<[u32; 3]>(count)?, frame.take::<u32>(n)?);
        let done = decimate(full_faces, full_vertex, history, surface.mesh, surface.twin, PROXY_FACES, frame)?;
        if done.faces > coarse_faces.len() || done.vertices > vertex.len() {
            return Ok(false);
        }
        coarse_faces[..done.faces].copy_from_slice(&full_faces[..done.faces]);
        vertex[..done.vertices].copy_from_slice(&full_vertex[..done.vertices]);
        done
    };
    let (coarse_faces, vertex) = (&coarse_faces[..done.faces], &vertex[..done.vertices]);
    let positions = scratch.take::<DVec3>(vertex.len())?;
    positions.iter_mut().zip(vertex).for_each(|(p, v)| *p = surface.mesh.positions[*v as usize]);
    let mesh = MeshView { positions, faces: coarse_faces };
    let twin = scratch.take::<u32>(mesh.corner_count())?;
    twins(twin, mesh, scratch.frame())?;
    let cost = scratch.take::<f64>(mesh.corner_count())?;
    proxy_costs(cost, mesh, twin, vertex, surface, scratch.frame())?;
    let rest = scratch.take::<Rest>(coarse_faces.len())?;
    for (r, f) in rest.iter_mut().zip(coarse_faces) {
        *r = Rest::new(f.map(|v| mesh.positions[v as usize]), MOLLIFY);
    }
    let coarse = Surface::new(mesh, twin, rest, cost, &mut scratch)?;
    let coarse_cut = scratch.take::<u8>(mesh.corner_count())?;
    let coarse_uv = scratch.take::<DVec2>(mesh.corner_count())?;
    make_charts(coarse_uv, coarse_cut, &coarse, budget, scratch.frame(), workers, proceed)?;
    let moved = transfer(cut, surface, &coarse, coarse_cut, &history[..done.collapses], SLIDES, scratch)?;
    Ok(moved.is_faithful() && moved.forbidden == 0)
}

/// Flattens every chart; a chart in which rounding flips a triangle is halved until none does.
fn flatten(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let changed = scratch.take_filled::<u8>(faces, 1)?;
    for _ in 0..HALVINGS {
        {
            let mut frame = scratch.frame();
            let charts = Charts::new(surface, cut, &mut frame)?;
            let touched = |k: usize| charts.faces_of(k).iter().any(|f| changed[*f as usize] != 0);
            work_on(uv, surface, cut, &charts, touched, Work::Flatten(FIRST_STOP), frame, workers)?;
        }
        changed.fill(0);
        let bad = |f: usize| !surface.rest[f].energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]).is_finite();
        if halve(cut, changed, surface, bad, scratch.frame())? == 0 {
            break;
        }
        disks_again(cut, surface, scratch.frame())?;
    }
    Ok(())
}

/// Parts each chart that has a bad face into two of about equal numbers of faces; marks the faces of those charts and
/// returns how many charts it parted. A chart of one polygon stays whole.
pub fn halve(
    cut: &mut [u8],
    changed: &mut [u8],
    surface: &Surface,
    bad: impl Fn(usize) -> bool,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let charts = Charts::new(surface, cut, &mut scratch)?;
    let side = scratch.take::<u8>(changed.len())?;
    let queue = scratch.take::<u32>(changed.len())?;
    let mut parted = 0;
    for k in 0..charts.count() {
        let faces = charts.faces_of(k);
        if !faces.iter().any(|f| bad(*f as usize)) {
            continue;
        }
        let mut spread = |seeds: &[u32], side: &mut [u8]| {
            faces.iter().for_each(|f| side[*f as usize] = 0);
            let (mut head, mut tail) = (0, 0);
            for (i, seed) in seeds.iter().enumerate() {
                side[*seed as usize] = 1 + i as u8;
                queue[tail] = *seed;
                tail += 1;
            }
            while head < tail {
                let f = queue[head];
                head += 1;
                for c in 3 * f..3 * f + 3 {
                    let Some(t) = surface.across(cut, c) else { continue };
                    if side[(t / 3) as usize] == 0 {
                        side[(t / 3) as usize] = side[f as usize];
                        queue[tail] = t / 3;
                        tail += 1;
                    }
                }
            }
            queue[tail - 1] // the farthest face
        };
        let a = spread(&faces[..1], side);
        let b = spread(&[a], side);
        if a != b {
            spread(&[a, b], side);
        }
        let mut any = false;
        for c in faces.iter().flat_map(|f| 3 * f..3 * f + 3) {
            if let Some(t) = surface.across(cut, c)
                && side[(c / 3) as usize] != side[(t / 3) as usize]
                && surface.cost[c as usize].is_finite()
            {
                surface.set_cut(cut, c, true);
                any = true;
            }
        }
        if any {
            faces.iter().for_each(|f| changed[*f as usize] = 1);
            parted += 1;
        }
    }
    Ok(parted)
}

/// Relaxes the charts that hold a changed face.
fn relax_changed(
    uv: &mut [DVec2],
    cut: &[u8],
    changed: &[u8],
    surface: &Surface,
    stop: Stop,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let charts = Charts::new(surface, cut, &mut scratch)?;
    let touched = |k: usize| charts.faces_of(k).iter().any(|f| changed[*f as usize] != 0);
    work_on(uv, surface, cut, &charts, touched, Work::Relax(stop), scratch, workers)?;
    Ok(())
}

/// Mean symmetric Dirichlet energy over 4, after the best global scale. Faces of no area to speak of do not count.
pub fn distortion(uv: &[DVec2], rest: &[Rest]) -> f64 {
    let (mut stretch, mut shrink, mut area) = (0.0, 0.0, 0.0);
    let flat = FLAT * rest.iter().map(|r| r.area).sum::<f64>() / rest.len().max(1) as f64;
    for (f, rest) in rest.iter().enumerate() {
        if rest.area <= flat {
            continue;
        }
        let [c0, c1] = rest.jacobian([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]);
        let (det, norm) = (c0.perp_dot(c1), c0.dot(c0) + c1.dot(c1));
        stretch += rest.area * norm;
        shrink += rest.area * norm / (det * det);
        area += rest.area;
    }
    if area > 0.0 { sqrt(stretch * shrink) / (2.0 * area) } else { 1.0 }
}

/// Adds cuts towards what is too distorted: up to `most` paths that lie apart. Returns how many.
pub fn extend(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    most: usize,
    share: f64,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let density = scratch.take::<f64>(n)?;
    let weight = scratch.take::<f64>(n)?;
    for (f, rest) in surface.rest.iter().enumerate() {
        let excess = rest.area * (rest.energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]) - 4.0);
        for v in surface.mesh.faces[f] {
            density[v as usize] += excess;
            weight[v as usize] += rest.area;
        }
    }
    for v in 0..n {
        density[v] /= weight[v].max(1e-300);
    }
    let smooth = scratch.take::<f64>(n)?;
    for _ in 0..2 {
        for v in 0..n as u32 {
            let (mut sum, mut total) = (density[v as usize] * weight[v as usize], weight[v as usize]);
            for (_, w) in surface.edges_at(v) {
                sum += density[w as usize] * weight[w as usize];
                total += weight[w as usize];
            }
            smooth[v as usize] = sum / total.max(1e-300);
        }
        density.copy_from_slice(smooth);
    }
    let mut paths = Paths::new(n, &mut scratch)?;
    let on_cut = scratch.take::<u8>(n)?;
    for c in 0..surface.mesh.corner_count() as u32 {
        if surface.is_open(cut, c) {
            on_cut[surface.mesh.vertex(c) as usize] = 1;
            on_cut[surface.mesh.vertex(next(c)) as usize] = 1;
        }
    }
    let order = scratch.take::<u32>(n)?;
    let mut len = 0;
    paths.grow(
        surface,
        (0..n as u32).filter(|v| on_cut[*v as usize] != 0),
        |c| surface.cost[c as usize],
        |v, _| {
            // A vertex may be settled once only here: no sources are added.
            order[len] = v;
            len += 1;
        },
    );
    let along = scratch.take::<f64>(n)?;
    let length = scratch.take::<f64>(n)?;
    let score = scratch.take::<f64>(n)?;
    for v in &order[..len] {
        let Some((c, from)) = paths.trace(surface, *v).next() else { continue };
        let (v, from) = (*v as usize, from as usize);
        let l = surface.length(c);
        length[v] = length[from] + l;
        along[v] = along[from] + l * 0.5 * (density[v] + density[from]);
        score[v] = for_decision(along[v] * length[v] / paths.cost[v].max(1e-300));
    }
    let order = &mut order[..len];
    order.sort_unstable_by(|a, b| score[*b as usize].total_cmp(&score[*a as usize]).then(a.cmp(b)));
    let near = scratch.take::<u8>(n)?;
    let mut added = 0;
    let best = order.first().map_or(0.0, |v| score[*v as usize]);
    let mut ball = Paths::new(n, &mut scratch)?;
    for v in order.iter() {
        if added == most || score[*v as usize] < share * best || score[*v as usize] <= 0.0 {
            break;
        }
        if near[*v as usize] != 0 || paths.trace(surface, *v).any(|(_, w)| near[w as usize] != 0) {
            continue;
        }
        for (c, _) in paths.trace(surface, *v) {
            surface.set_cut(cut, c, true);
            changed[(c / 3) as usize] = 1;
        }
        added += 1;
        let radius = length[*v as usize];
        ball.grow(
            surface,
            core::iter::once(*v).chain(paths.trace(surface, *v).map(|(_, w)| w)),
            |c| surface.length(c),
            |w, reached| {
                if reached.cost[w as usize] > radius {
                    reached.stop = true;
                } else {
                    near[w as usize] = 1;
                }
            },
        );
    }
    Ok(added)
}
