//! Extending cuts towards what is too distorted.
//!
//! Cheapest paths run from all cuts and borders to every vertex; a path is worth the distortion that it meets, times its
//! length, over its cost. The best few that lie apart are cut (after OptCuts, Li et al. 2018, which tries each cut; here
//! the worth is estimated, and several are made at once). An edge between two cuts is a path as well.
//! Guarantee: disks stay disks: a path that ends freely is a slit, one that ends on another cut parts a chart in two.
//! Cost: O(n log n).

use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::charts::paths::Paths;
use crate::charts::surface::Surface;
use crate::mesh::view::next;
use crate::price::cost::FORBIDDEN;
use glam::DVec2;

/// Paths worth less than this share of the best wait for the next round.
const SHARE: f64 = 0.5;

/// Adds cuts towards the faces whose energy is above `least` (4: what is distorted at all): up to `most` paths that lie apart,
/// and an edge between two cuts where that is worth more. Returns how many.
pub fn extend(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    least: f64,
    most: usize,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let density = scratch.take::<f64>(n)?;
    spread_excess(density, uv, surface, least, scratch.frame())?;
    let on_cut = scratch.take::<u8>(n)?;
    for c in (0..surface.mesh.corner_count() as u32).filter(|c| surface.is_open(cut, *c)) {
        on_cut[surface.mesh.vertex(c) as usize] = 1;
        on_cut[surface.far_end(c) as usize] = 1;
    }
    let mut paths = Paths::new(n, &mut scratch)?;
    let order = scratch.take::<u32>(n)?;
    let reached = grow_from_cuts(order, &mut paths, on_cut, surface);
    let order = &mut order[..reached];
    let worth = Worth::new(order, &paths, density, surface, &mut scratch)?;
    sort::by(order, |a, b| worth.score[*b as usize].total_cmp(&worth.score[*a as usize]).then(a.cmp(b)));
    let best = order.first().map_or(0.0, |v| worth.score[*v as usize]);
    let mut added = cut_apart(cut, changed, order, most, &paths, &worth, surface, scratch)?;
    if !surface.stays_whole
        && let Some((worth, c)) = best_chord(cut, on_cut, density, surface)
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
) -> Result<(), ScratchTooSmall> {
    let n = density.len();
    let weight = scratch.take::<f64>(n)?;
    for (f, rest) in surface.rest.iter().enumerate() {
        let energy = rest.energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]);
        let excess = rest.weight * (energy - least).max(0.0);
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
        density.copy_from(smooth);
    }
    Ok(())
}

/// Grows cheapest paths from all cuts and borders; lists the vertices in the order of their cost, and returns how many there are.
fn grow_from_cuts(order: &mut [u32], paths: &mut Paths, on_cut: &[u8], surface: &Surface) -> usize {
    let mut len = 0;
    paths.grow(
        surface,
        (0..on_cut.len() as u32).filter(|v| on_cut[*v as usize] != 0),
        |c| surface.cost[c as usize],
        |v, _| {
            // A vertex may be settled once only here: no sources are added.
            order[len] = v;
            len += 1;
        },
    );
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
fn best_chord(cut: &[u8], on_cut: &[u8], density: &[f64], surface: &Surface) -> Option<(f64, u32)> {
    let mut best: Option<(f64, u32)> = None;
    for c in 0..surface.mesh.corner_count() as u32 {
        let Some(t) = surface.across(cut, c) else { continue };
        let (a, b) = (surface.mesh.vertex(c) as usize, surface.mesh.vertex(next(c)) as usize);
        let cost = surface.cost[c as usize];
        if c < t && on_cut[a] != 0 && on_cut[b] != 0 && cost < FORBIDDEN {
            let length = surface.length(c);
            let worth = for_decision(length * length * 0.5 * (density[a] + density[b]) / cost.max(1e-300));
            if best.is_none_or(|b| worth > b.0) {
                best = Some((worth, c));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::solve::energy::Rest;
    use glam::DVec3;

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
        let added = extend(&mut cut, &mut changed, &uv, &surface, least, 3, Scratch::new(bytes));
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
    fn too_little_memory_is_an_error_and_cuts_nothing() {
        let (added, cut) = cut_square(2.0, 4.0, &mut [0; 64]);
        assert!(added.is_err());
        assert_eq!(cut, [0; 6]);
    }
}
