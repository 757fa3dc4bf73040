//! Seam optimisation: one budget of distortion, spent where it hides most.

use super::charts::{Charts, Work, job_need, work_on};
use super::cut::{Paths, cut_to_disks};
use super::energy::Rest;
use super::relax::Stop;
use super::split::split_overlaps;
use super::surface::Surface;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::Workers;
use crate::mesh::overlap::overlaps_need;
use crate::mesh::view::next;
use glam::DVec2;

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

/// Rounds of extension at the most; each adds paths where the distortion is worst.
const ROUNDS: usize = 80;
/// Rounds of splitting at the most.
const SPLITS: usize = 60;
/// Newton steps of a round: the map need not be at rest before the next cut is chosen.
const ROUND_STOP: Stop = Stop { steps: 5, tolerance: 1e-4 };
/// Newton steps of the first flattening.
const FIRST_STOP: Stop = Stop { steps: 60, tolerance: 1e-3 };
/// Newton steps at the end.
const LAST_STOP: Stop = Stop { steps: 30, tolerance: 1e-6 };

/// Scratch bytes that [`make_charts`] asks for.
pub fn make_charts_need(faces: usize, vertices: usize) -> usize {
    let corners = 3 * faces;
    let lists = bytes_for::<u8>(faces) + 3 * bytes_for::<u32>(faces + 2);
    let growing = 12 * bytes_for::<f64>(vertices) + 12 * bytes_for::<u32>(vertices) + bytes_for::<[u64; 2]>(corners);
    let splitting = 10 * bytes_for::<u32>(faces) + 12 * bytes_for::<u32>(corners) + 24 * faces + overlaps_need(faces);
    let jobs = 4 * bytes_for::<u32>(corners) + job_need(faces);
    lists + growing.max(splitting).max(jobs)
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
    let changed = scratch.take::<u8>(surface.mesh.faces.len())?;
    cut_to_disks(cut, surface, scratch.frame())?;
    flatten(uv, cut, surface, scratch.frame(), workers)?;
    for _ in 0..ROUNDS {
        if !proceed() {
            return Err(SeamError::Stopped);
        }
        if distortion(uv, surface.rest) <= budget.distortion {
            break;
        }
        changed.fill(0);
        if extend(cut, changed, uv, surface, 3, 0.5, scratch.frame())? == 0 {
            break;
        }
        relax_changed(uv, cut, changed, surface, ROUND_STOP, scratch.frame(), workers)?;
    }
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

/// Flattens every chart; where rounding flips a triangle, the chart is cut on until none is.
fn flatten(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let charts = Charts::new(surface, cut, &mut scratch)?;
    work_on(uv, surface, cut, &charts, |_| true, Work::Flatten(FIRST_STOP), scratch, workers)?;
    Ok(())
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

/// Mean symmetric Dirichlet energy over 4, after the best global scale.
pub fn distortion(uv: &[DVec2], rest: &[Rest]) -> f64 {
    let (mut stretch, mut shrink, mut area) = (0.0, 0.0, 0.0);
    for (f, rest) in rest.iter().enumerate() {
        let [c0, c1] = rest.jacobian([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]);
        let (det, norm) = (c0.perp_dot(c1), c0.dot(c0) + c1.dot(c1));
        stretch += rest.area * norm;
        shrink += rest.area * norm / (det * det);
        area += rest.area;
    }
    sqrt(stretch * shrink) / (2.0 * area)
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
        score[v] = along[v] * length[v] / paths.cost[v].max(1e-300);
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
