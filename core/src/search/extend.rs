//! Extending cuts towards what is too distorted.
//!
//! Cheapest paths run from all cuts and borders to every vertex; a path is worth the distortion that it meets, times its
//! length, over its cost. The best few that lie apart are cut (after OptCuts, Li et al. 2018, which tries each cut; here
//! the worth is estimated, and several are made at once). An edge between two cuts is a path as well.
//! Guarantee: disks stay disks: a path that ends freely is a slit, one that ends on another cut parts a chart in two.
//! Cost: O(n log n) in the charts that hold what is too distorted.

use crate::base::listing::list_once;
use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::{Workers, for_each_chunk};
use crate::charts::inland::grow_inland;
use crate::charts::paths::Paths;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};
use crate::price::cost::FORBIDDEN;
use glam::DVec2;

/// Paths worth less than this share of the best wait for the next round.
const SHARE: f64 = 0.5;
/// Where fewer than one vertex of so many is distorted, only the charts of those are looked at.
const FEW: usize = 8;
/// Faces, vertices or half-edges of a task.
const CHUNK: usize = 8192;

/// Adds cuts towards the faces whose energy is above `least` (4: what is distorted at all): up to `most` paths that lie apart,
/// and an edge between two cuts where that is worth more. Returns how many.
#[allow(clippy::too_many_arguments)]
pub fn extend(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    least: f64,
    most: usize,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let density = scratch.take::<f64>(n)?;
    spread_excess(density, uv, surface, least, scratch.frame(), workers)?;
    let on_cut = scratch.take::<u8>(n)?;
    for c in (0..surface.mesh.corner_count() as u32).filter(|c| surface.is_open(cut, *c)) {
        on_cut[surface.mesh.vertex(c) as usize] = 1;
        on_cut[surface.far_end(c) as usize] = 1;
    }
    let mut paths = Paths::new(n, &mut scratch)?;
    let order = scratch.take::<u32>(n)?;
    let within = scratch.take::<u8>(n)?;
    let is_whole = mark_worth_reaching(within, order, density, on_cut, surface);
    let inland = match is_whole {
        true => grow_inland(&mut paths, order, on_cut, surface, scratch.frame(), workers)?,
        false => None,
    };
    let sources = (0..n as u32).filter(|v| on_cut[*v as usize] != 0 && within[*v as usize] != 0);
    let reached = match inland {
        Some(reached) => reached,
        None => grow_from(sources, order, &mut paths, surface, |c| {
            let ends = [surface.mesh.vertex(c), surface.far_end(c)];
            if ends.iter().all(|v| within[*v as usize] != 0) { surface.cost[c as usize] } else { f64::INFINITY }
        }),
    };
    let order = &mut order[..reached];
    let worth = Worth::new(order, &paths, density, surface, &mut scratch)?;
    let best = order.iter().map(|v| worth.score[*v as usize]).fold(0.0, f64::max);
    let kept = keep(order, |v| worth.score[v as usize] >= SHARE * best && worth.score[v as usize] > 0.0);
    let order = &mut order[..kept];
    sort::by(order, |a, b| worth.score[*b as usize].total_cmp(&worth.score[*a as usize]).then(a.cmp(b)));
    let mut added = cut_apart(cut, changed, order, most, &paths, &worth, surface, scratch.frame())?;
    if !surface.stays_whole
        && let Some((worth, c)) = best_chord(cut, on_cut, density, surface, scratch.frame(), workers)?
        && worth > best
    {
        surface.set_cut(cut, c, true);
        changed[(c / 3) as usize] = 1;
        changed[(surface.twin[c as usize] / 3) as usize] = 1;
        added += 1;
    }
    Ok(added)
}

/// Writes what the faces at each vertex have above `least`, over their area, smoothed over its neighbours.
fn spread_excess(
    density: &mut [f64],
    uv: &[DVec2],
    surface: &Surface,
    least: f64,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let n = density.len();
    let weight = scratch.take::<f64>(n)?;
    {
        let mut frame = scratch.frame();
        let excess = frame.take_unset::<f64>(surface.rest.len())?;
        for_each_chunk(workers, excess, CHUNK, &|chunk, excess| {
            for (f, excess) in (chunk * CHUNK..).zip(excess) {
                let energy = surface.rest[f].energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]);
                *excess = surface.rest[f].weight * (energy - least).max(0.0);
            }
        });
        for_each_chunk(workers, density, CHUNK, &|chunk, density| {
            for (v, density) in (chunk * CHUNK..).zip(density) {
                // In the order of faces, once for each corner.
                *density = surface.corners_at(v as u32).iter().fold(0.0, |sum, c| sum + excess[*c as usize / 3]);
            }
        });
    }
    for_each_chunk(workers, weight, CHUNK, &|chunk, weight| {
        for (v, weight) in (chunk * CHUNK..).zip(weight) {
            *weight = surface.corners_at(v as u32).iter().fold(0.0, |sum, c| sum + surface.rest[*c as usize / 3].area);
        }
    });
    for v in 0..n {
        density[v] /= weight[v].max(1e-300);
    }
    let smoothed = |density: &[f64], v: u32| {
        let (mut sum, mut total) = (density[v as usize] * weight[v as usize], weight[v as usize]);
        for (_, w) in surface.edges_at(v) {
            sum += density[w as usize] * weight[w as usize];
            total += weight[w as usize];
        }
        sum / total.max(1e-300)
    };
    let smooth = scratch.take::<f64>(n)?;
    if density.iter().filter(|d| **d > 0.0).count() > n / FEW {
        for _ in 0..2 {
            for_each_chunk(workers, smooth, CHUNK, &|chunk, smooth| {
                smooth.iter_mut().zip((chunk * CHUNK) as u32..).for_each(|(s, v)| *s = smoothed(density, v));
            });
            density.copy_from(smooth);
        }
        return Ok(());
    }
    // Where nothing is above it for two edges around, nothing comes out: few places need smoothing where few faces are.
    let (list, is_listed) = (scratch.take::<u32>(n)?, scratch.take::<u8>(n)?);
    let mut count = 0;
    for (v, _) in density.iter().enumerate().filter(|(_, d)| **d > 0.0) {
        count += list_once(v as u32, is_listed, list, count);
    }
    for _ in 0..2 {
        let listed = count;
        for i in 0..listed {
            for (_, w) in surface.edges_at(list[i]) {
                count += list_once(w, is_listed, list, count);
            }
        }
        list[..count].iter().for_each(|v| smooth[*v as usize] = smoothed(density, *v));
        list[..count].iter().for_each(|v| density[*v as usize] = smooth[*v as usize]);
    }
    Ok(())
}

/// Moves the items that are wanted to the front, in their order; returns how many there are.
fn keep(list: &mut [u32], is_wanted: impl Fn(u32) -> bool) -> usize {
    let mut kept = 0;
    for i in 0..list.len() {
        let item = list[i];
        if is_wanted(item) {
            list[kept] = item;
            kept += 1;
        }
    }
    kept
}

/// Marks the vertices to which a path may be worth anything, with all that cheapest paths to them come through: what can be reached from
/// distorted places without passing a cut, for paths begin on cuts. Returns whether those are all vertices; `list` is memory.
fn mark_worth_reaching(within: &mut [u8], list: &mut [u32], density: &[f64], on_cut: &[u8], surface: &Surface) -> bool {
    let distorted = density.iter().filter(|d| **d > 0.0).count();
    if distorted > density.len() / FEW {
        within.fill(1);
        return true;
    }
    let mut count = 0;
    for (v, _) in density.iter().enumerate().filter(|(_, d)| **d > 0.0) {
        count += list_once(v as u32, within, list, count);
    }
    let mut at = 0;
    while at < count {
        let v = list[at];
        if at < distorted || on_cut[v as usize] == 0 {
            for (_, w) in surface.edges_at(v) {
                count += list_once(w, within, list, count);
            }
        }
        at += 1;
    }
    count == density.len()
}

/// Grows cheapest paths from `sources`; lists the vertices in the order of their cost, and returns how many there are.
fn grow_from(
    sources: impl Iterator<Item = u32>,
    order: &mut [u32],
    paths: &mut Paths,
    surface: &Surface,
    cost: impl Fn(u32) -> f64,
) -> usize {
    let mut len = 0;
    paths.grow(surface, sources, cost, |v, _| {
        // A vertex may be settled once only here: no sources are added.
        order[len] = v;
        len += 1;
    });
    len
}

/// What the cheapest path to each vertex is worth.
struct Worth<'w> {
    length: &'w [f64], // (n)
    score: &'w [f64],  // (n) distortion along the path, times its length, over its cost
}

impl<'w> Worth<'w> {
    /// `order` lists the vertices in the order in which they were reached.
    fn new(
        order: &[u32],
        paths: &Paths,
        density: &[f64],
        surface: &Surface,
        keep: &mut Scratch<'w>,
    ) -> Result<Self, ScratchTooSmall> {
        let along = keep.take::<f64>(density.len())?;
        let length = keep.take::<f64>(density.len())?;
        let score = keep.take::<f64>(density.len())?;
        for v in order {
            let Some((c, from)) = paths.trace(surface, *v).next() else { continue };
            let (v, from) = (*v as usize, from as usize);
            let l = surface.length(c);
            length[v] = length[from] + l;
            along[v] = along[from] + l * 0.5 * (density[v] + density[from]);
            score[v] = for_decision(along[v] * length[v] / paths.cost[v].max(1e-300));
        }
        Ok(Self { length, score })
    }
}

/// Cuts up to `most` of the paths to the vertices of `order`, the best first, that keep their own length away from each other;
/// returns how many.
#[allow(clippy::too_many_arguments)]
fn cut_apart(
    cut: &mut [u8],
    changed: &mut [u8],
    order: &[u32],
    most: usize,
    paths: &Paths,
    worth: &Worth,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let near = scratch.take::<u8>(n)?;
    let mut ball = Paths::new(n, &mut scratch)?;
    let best = order.first().map_or(0.0, |v| worth.score[*v as usize]);
    let mut added = 0;
    for v in order.iter() {
        let score = worth.score[*v as usize];
        if added == most || score < SHARE * best || score <= 0.0 {
            break;
        }
        if paths.cost[*v as usize] >= FORBIDDEN
            || near[*v as usize] != 0
            || paths.trace(surface, *v).any(|(_, w)| near[w as usize] != 0)
        {
            continue;
        }
        for (c, _) in paths.trace(surface, *v) {
            surface.set_cut(cut, c, true);
            changed[(c / 3) as usize] = 1;
        }
        added += 1;
        let radius = worth.length[*v as usize];
        let path = core::iter::once(*v).chain(paths.trace(surface, *v).map(|(_, w)| w));
        ball.grow(
            surface,
            path,
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

/// The edge between two places on cuts that is worth most, with its worth. Charts without inner vertices have no other
/// paths.
fn best_chord(
    cut: &[u8],
    on_cut: &[u8],
    density: &[f64],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Option<(f64, u32)>, ScratchTooSmall> {
    let worth = |c: u32| {
        let t = surface.across(cut, c)?;
        let (a, b) = (surface.mesh.vertex(c) as usize, surface.mesh.vertex(next(c)) as usize);
        let cost = surface.cost[c as usize];
        (c < t && on_cut[a] != 0 && on_cut[b] != 0 && cost < FORBIDDEN).then(|| {
            let length = surface.length(c);
            for_decision(length * length * 0.5 * (density[a] + density[b]) / cost.max(1e-300))
        })
    };
    let better = |best: Option<(f64, u32)>, c: u32| match worth(c) {
        Some(worth) if best.is_none_or(|b| worth > b.0) => Some((worth, c)),
        _ => best,
    };
    let corners = surface.mesh.corner_count() as u32;
    let chunk = CHUNK as u32;
    let found = scratch.take_filled::<u32>(corners.div_ceil(chunk) as usize, NONE)?;
    for_each_chunk(workers, found, 1, &|k, found| {
        let first = k as u32 * chunk;
        let best = (first..first.saturating_add(chunk).min(corners)).fold(None, better);
        found[0] = best.map_or(NONE, |b| b.1);
    });
    Ok(found.iter().copied().filter(|c| *c != NONE).fold(None, better))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use crate::base::workers::Serial;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::solve::energy::Rest;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// Two triangles of a square, mapped at `scale`.
    fn cut_square(scale: f64, least: f64, bytes: &mut [u8]) -> (Result<usize, ScratchTooSmall>, [u8; 6]) {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let positions = corners.map(|(x, y)| DVec3::new(x, y, 0.0));
        let faces = [[0, 1, 2], [0, 2, 3]];
        let mesh = MeshView { positions: &positions, faces: &faces };
        let (mut memory, mut twin) = ([0; 4096], [0; 6]);
        let mut keep = Scratch::new(&mut memory);
        twins(&mut twin, mesh, keep.frame()).expect("enough memory");
        let rest = faces.map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0));
        let surface = Surface::new(mesh, &twin, &rest, &[1.0; 6], &mut keep).expect("enough memory");
        let uv = [0, 1, 2, 0, 2, 3].map(|v: usize| positions[v].truncate() * scale);
        let (mut cut, mut changed) = ([0; 6], [0; 2]);
        let added = extend(&mut cut, &mut changed, &uv, &surface, least, 3, Scratch::new(bytes), &Serial);
        (added, cut)
    }

    #[test]
    fn a_chart_without_inner_vertices_is_cut_along_an_edge() {
        // The diagonal is half-edge 2 of the first triangle and half-edge 0 of the second.
        assert_eq!(cut_square(2.0, 4.0, &mut [0; 4096]), (Ok(1), [0, 0, 1, 1, 0, 0]));
    }

    #[test]
    fn where_nothing_is_distorted_nothing_is_cut() {
        assert_eq!(cut_square(1.0, 4.0, &mut [0; 4096]), (Ok(0), [0; 6]));
    }

    #[test]
    fn faces_below_the_least_energy_call_for_no_cut() {
        // At twice the size a face has the energy 8.5.
        assert_eq!(cut_square(2.0, 8.4, &mut [0; 4096]).0, Ok(1));
        assert_eq!(cut_square(2.0, 8.6, &mut [0; 4096]).0, Ok(0));
    }

    #[test]
    fn places_that_nothing_distorted_reaches_are_not_missed() {
        // A sheet of 24 x 24 squares, cut in two, with some vertices pulled out of place on either side of the cut or on it.
        let side = 24u32;
        let positions: Vec<DVec3> =
            (0..=side).flat_map(|y| (0..=side).map(move |x| DVec3::new(x.into(), y.into(), 0.0))).collect();
        let square = |v: u32| [[v, v + 1, v + side + 2], [v, v + side + 2, v + side + 1]];
        let faces: Vec<[u32; 3]> =
            (0..side).flat_map(|y| (0..side).flat_map(move |x| square(y * (side + 1) + x))).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let (mut memory, mut twin) = (vec![0; 1 << 20], vec![0; 3 * faces.len()]);
        let mut keep = Scratch::new(&mut memory);
        twins(&mut twin, mesh, keep.frame()).expect("enough memory");
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
        let costs: Vec<f64> =
            (0..twin.len() as u32).map(|c| 1.0 + unit_f64(3, 0, c.min(twin[c as usize]).into())).collect();
        let surface = Surface::new(mesh, &twin, &rest, &costs, &mut keep).expect("enough memory");
        let mut cut = vec![0; twin.len()];
        for c in
            (0..twin.len() as u32).filter(|c| [mesh.position(*c), mesh.position(next(*c))].iter().all(|p| p.x == 11.0))
        {
            surface.set_cut(&mut cut, c, true);
        }
        for pulled in [vec![30], vec![11 + 25 * 8], vec![12 + 25 * 8, 400], vec![10 + 25 * 20]] {
            let uv: Vec<DVec2> = (0..twin.len() as u32)
                .map(|c| {
                    mesh.position(c).truncate()
                        + if pulled.contains(&mesh.vertex(c)) { DVec2::splat(0.4) } else { DVec2::ZERO }
                })
                .collect();
            let n = positions.len();
            let (mut density, mut on_cut) = (vec![0.0; n], vec![0; n]);
            spread_excess(&mut density, &uv, &surface, 4.0, keep.frame(), &Serial).expect("enough memory");
            for c in (0..twin.len() as u32).filter(|c| surface.is_open(&cut, *c)) {
                (on_cut[mesh.vertex(c) as usize], on_cut[surface.far_end(c) as usize]) = (1, 1);
            }
            let (mut within, mut order) = (vec![0; n], vec![0; n]);
            assert!(!mark_worth_reaching(&mut within, &mut order, &density, &on_cut, &surface), "few are distorted");
            let scores = |within: &[u8], order: &mut [u32], keep: &mut Scratch| {
                let mut frame = keep.frame();
                let mut paths = Paths::new(n, &mut frame).expect("enough memory");
                let sources = (0..n as u32).filter(|v| on_cut[*v as usize] != 0 && within[*v as usize] != 0);
                let inside = |c: u32| [mesh.vertex(c), surface.far_end(c)].iter().all(|v| within[*v as usize] != 0);
                let cost = |c: u32| if inside(c) { costs[c as usize] } else { f64::INFINITY };
                let reached = grow_from(sources, order, &mut paths, &surface, cost);
                let worth =
                    Worth::new(&order[..reached], &paths, &density, &surface, &mut frame).expect("enough memory");
                worth.score.to_vec()
            };
            let few = scores(&within, &mut order, &mut keep);
            assert!(few.iter().any(|s| *s > 0.0) && within.contains(&0));
            assert_eq!(few, scores(&vec![1; n], &mut order, &mut keep), "{pulled:?}");
        }
    }

    #[test]
    fn too_little_memory_is_an_error_and_cuts_nothing() {
        let (added, cut) = cut_square(2.0, 4.0, &mut [0; 64]);
        assert!(added.is_err());
        assert_eq!(cut, [0; 6]);
    }
}
