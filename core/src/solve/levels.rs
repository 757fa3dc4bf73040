//! First flattening of large charts by levels.
//!
//! The chart is decimated, the coarse chart flattened and relaxed, and the vertices are put back in turn: each where its triangles
//! are nearest to congruent, then to where its own Newton steps lead. At every doubling of the faces all nodes take such steps.
//! What is left for the solver on all nodes is a map near rest. After Hormann, Greiner, Campagna 1999 (hierarchical
//! parametrization) and Sander et al. 2002 (signal-stretch, coarse to fine).
//! Guarantee: no triangle flips. Limit: where a vertex finds no place by rounding, the answer says so, and the caller flattens
//! directly. Cost: O(n log n).

use super::energy::{MOLLIFY, OWN_BLOCK, Rest, even_out};
use super::flatten::tutte;
use super::piece::{Piece, Stop};
use super::relax::relax;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::mesh::collapse::{Collapse, CornerTable, fan};
use crate::mesh::decimate::decimate;
use crate::mesh::loops::next_on_border;
use crate::mesh::topology::twins;
use crate::mesh::view::{MeshView, NONE, next};
use glam::{DVec2, DVec3};

/// Charts of more triangles are flattened by levels.
pub const LEVELS_FROM: usize = 8000;
/// Triangles of the coarse chart.
const COARSE: usize = 2500;
/// When the coarse chart is at rest.
const COARSE_STOP: Stop = Stop { steps: 60, tolerance: 1e-3 };
/// Times that all nodes take a step of their own at a doubling.
const SWEEPS: usize = 1;
/// Triangles around a node that are looked at; a node with more keeps its place.
const MOST: usize = 64;
/// Mean energy around a node from which it is strained.
const STRAINED: f64 = 8.0;
/// Rounds in which it is eased.
const EASINGS: usize = 12;
/// Times that a node's step is shortened, and by how much.
const SHORTER: usize = 6;
/// See [`SHORTER`].
const SHORTEN: f64 = 0.4;
/// Sufficient decrease of a node's step (Armijo).
const DECREASE: f64 = 1e-4;
/// Shares of the shortest way to a neighbour that are tried where the congruent place is taken.
const NEAR: [f64; 5] = [0.5, 0.1, 1e-2, 1e-3, 1e-5];

/// Writes `x`, the disk flat, where all of it could be put back. Nodes `inner..` are its border.
pub fn flatten_by_levels(
    x: &mut [DVec2],
    piece: &Piece,
    inner: usize,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    let fine = MeshView { positions: piece.at, faces: piece.triangles };
    let twin = scratch.take::<u32>(fine.corner_count())?;
    if twins(twin, fine, scratch.frame())? != 0 {
        return Ok(false);
    }
    let history = scratch.take::<Collapse>(x.len())?;
    let faces = scratch.take::<[u32; 3]>(2 * COARSE)?;
    let vertex = scratch.take::<u32>(2 * COARSE)?;
    let done = {
        let mut frame = scratch.frame();
        let (all_faces, all_vertex) =
            (frame.take::<[u32; 3]>(fine.faces.len())?, frame.take::<u32>(fine.positions.len())?);
        let soft = frame.take::<u8>(twin.len())?;
        let done = decimate(all_faces, all_vertex, history, fine, twin, soft, COARSE, frame.frame())?;
        if done.faces > faces.len() || done.vertices > vertex.len() {
            return Ok(false);
        }
        faces[..done.faces].copy_from(&all_faces[..done.faces]);
        vertex[..done.vertices].copy_from(&all_vertex[..done.vertices]);
        done
    };
    let (faces, vertex, history) = (&faces[..done.faces], &vertex[..done.vertices], &history[..done.collapses]);
    if !flatten_coarse(x, piece, inner, faces, vertex, scratch.frame(), workers)? {
        return Ok(false);
    }
    let full = scratch.take::<[u32; 3]>(piece.triangles.len())?;
    full.copy_from(piece.triangles);
    let corner = scratch.take_filled::<u32>(x.len(), NONE)?;
    let dead = scratch.take::<u8>(full.len())?;
    let mut table = CornerTable { faces: full, twin };
    for collapse in history {
        collapse.sides(table.twin).for_each(|side| dead[(side.apex / 3) as usize] = 1);
        table.apply(*collapse);
    }
    let live = (0..3 * dead.len()).filter(|c| dead[c / 3] == 0);
    live.for_each(|c| corner[table.faces[c / 3][c % 3] as usize] = c as u32);
    let area = piece.rest.iter().map(|r| r.area).sum();
    Ok(Levels { x, piece, table, corner, faces: done.faces, area }.put_back(history))
}

/// Flattens and relaxes the coarse chart, whose node `k` is `vertex[k]` of the fine one; false where that has no map.
fn flatten_coarse(
    x: &mut [DVec2],
    piece: &Piece,
    inner: usize,
    faces: &[[u32; 3]],
    vertex: &[u32],
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    // `vertex` ascends, so that inner nodes come first here too.
    let coarse_inner = vertex.partition_point(|v| (*v as usize) < inner);
    let at = scratch.take::<DVec3>(vertex.len())?;
    at.iter_mut().zip(vertex).for_each(|(p, v)| *p = piece.at[*v as usize]);
    let twin = scratch.take::<u32>(3 * faces.len())?;
    let mesh = MeshView { positions: at, faces };
    twins(twin, mesh, scratch.frame())?;
    let border = scratch.take::<[u32; 2]>(vertex.len() - coarse_inner)?;
    let first = (0..twin.len() as u32).find(|c| twin[*c as usize] == NONE);
    let (mut at_corner, mut sides) = (first, 0);
    while let Some(c) = at_corner {
        let Some(side) = border.get_mut(sides) else { return Ok(false) };
        *side = [mesh.vertex(c), mesh.vertex(next(c))];
        sides += 1;
        at_corner = Some(next_on_border(twin, c)).filter(|after| Some(*after) != first);
    }
    if sides != border.len() || sides < 3 {
        return Ok(false);
    }
    let rest = scratch.take::<Rest>(faces.len())?;
    rest.iter_mut().zip(faces).for_each(|(r, f)| *r = Rest::new(f.map(|v| at[v as usize]), MOLLIFY));
    even_out(rest);
    let y = scratch.take::<DVec2>(vertex.len())?;
    let coarse = Piece { triangles: faces, rest, free: vertex.len(), at, springs: &[], walls: &[] };
    tutte(y, &coarse, coarse_inner, border, scratch.frame(), workers)?;
    let relaxed = relax(y, &coarse, COARSE_STOP, scratch, workers)?;
    vertex.iter().zip(y.iter()).for_each(|(v, y)| x[*v as usize] = *y);
    Ok(relaxed.after.is_finite())
}

/// A triangle at a node: its rest shape, its nodes, and which of them that node is.
#[derive(Clone, Copy)]
struct Beside {
    rest: Rest,
    nodes: [u32; 3],
    own: usize,
}

/// The triangles around a node.
type Star = heapless::Vec<Beside, MOST>;

/// A chart whose vertices are being put back.
struct Levels<'l> {
    x: &'l mut [DVec2],
    piece: &'l Piece<'l>,
    table: CornerTable<'l>,
    corner: &'l mut [u32], // (n) a corner of each node that is there
    faces: usize,          // that are there
    area: f64,             // of the whole piece
}

impl Levels<'_> {
    /// Takes all collapses back; false where a vertex finds no place.
    fn put_back(&mut self, history: &[Collapse]) -> bool {
        let mut next_sweep = 2 * self.faces;
        for collapse in history.iter().rev() {
            self.table.undo(*collapse);
            let side = collapse.side();
            let [removed, kept] = self.table.ends(*collapse);
            self.faces += collapse.sides(self.table.twin).count();
            self.corner[removed as usize] = side.removed;
            self.corner[kept as usize] = side.kept;
            self.corner[self.table.vertex(side.apex) as usize] = side.apex;
            let Some(star) = self.star(removed) else { return false };
            let Some(place) = self.place(*collapse, removed, kept, &star) else { return false };
            self.x[removed as usize] = place;
            self.step(removed, &star);
            self.step(removed, &star);
            self.ease(removed, &star);
            if self.faces >= next_sweep || self.faces == self.piece.triangles.len() {
                next_sweep = 2 * self.faces;
                self.sweep();
            }
        }
        true
    }

    /// Lets a node and its neighbours take steps in turn as long as the triangles around it are strained: a thin triangle grows by
    /// half a step, so that one left behind would keep the solver busy.
    fn ease(&mut self, node: u32, star: &Star) {
        let weight: f64 = star.iter().map(|b| b.rest.weight).sum();
        for _ in 0..EASINGS {
            if self.energy(star, self.x[node as usize]) <= STRAINED * weight {
                break;
            }
            for other in star.iter().map(|b| b.nodes[(b.own + 1) % 3]) {
                if let Some(star) = self.star(other) {
                    self.step(other, &star);
                }
            }
            self.step(node, star);
        }
    }

    /// Lets every node that is there take steps of its own.
    fn sweep(&mut self) {
        for _ in 0..SWEEPS {
            for node in 0..self.corner.len() as u32 {
                if self.corner[node as usize] != NONE
                    && let Some(star) = self.star(node)
                {
                    self.step(node, &star);
                }
            }
        }
    }

    /// The triangles around a node, if they are not too many.
    fn star(&self, node: u32) -> Option<Star> {
        let mut star = Star::new();
        let whole = self.faces == self.piece.triangles.len();
        for c in fan(self.table.twin, self.corner[node as usize]) {
            let f = (c / 3) as usize;
            let nodes = self.table.faces[f];
            let rest = if whole {
                self.piece.rest[f]
            } else {
                let mut rest = Rest::new(nodes.map(|i| self.piece.at[i as usize]), MOLLIFY);
                rest.even_out(self.area / self.faces as f64);
                rest
            };
            star.push(Beside { rest, nodes, own: (c % 3) as usize }).ok()?;
        }
        Some(star)
    }

    /// Energy around a node, were it at `p`.
    fn energy(&self, star: &Star, p: DVec2) -> f64 {
        let one = |b: &Beside| {
            let mut q = b.nodes.map(|i| self.x[i as usize]);
            q[b.own] = p;
            b.rest.weight * b.rest.objective(q)
        };
        star.iter().map(one).sum()
    }

    /// Where a vertex that comes back may be without a flip: where its triangles are congruent, on the mean, or beside the vertex that
    /// it was moved onto.
    fn place(&self, collapse: Collapse, removed: u32, kept: u32, star: &Star) -> Option<DVec2> {
        let (mut sum, mut area) = (DVec2::ZERO, 0.0);
        for b in star {
            // Named from the corner after the node's.
            let rest = (0..(b.own + 1) % 3).fold(b.rest, |rest, _| rest.turned());
            let [p, q] = [1, 2].map(|i| self.x[b.nodes[(b.own + i) % 3] as usize]);
            sum += rest.unfold(p, q) * rest.area;
            area += rest.area;
        }
        let congruent = sum / area.max(f64::MIN_POSITIVE);
        if self.energy(star, congruent).is_finite() {
            return Some(congruent);
        }
        let from = self.x[kept as usize];
        let way = self.way(collapse, from);
        let reach = star.iter().flat_map(|b| b.nodes).filter(|i| *i != removed && *i != kept);
        let reach = reach.map(|i| from.distance(self.x[i as usize])).fold(f64::INFINITY, f64::min);
        let near = NEAR.map(|share| from + way * (share * reach));
        let best = near.map(|p| (self.energy(star, p), p)).into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        best.0.is_finite().then_some(best.1)
    }

    /// The direction, from the kept vertex at `from`, in which the removed one has its room: midway between the edges to the third
    /// vertices of the triangles that come back, or across the one.
    fn way(&self, collapse: Collapse, from: DVec2) -> DVec2 {
        let unit = |d: DVec2| d / sqrt(d.dot(d)).max(f64::MIN_POSITIVE);
        // Room is to the left of one and to the right of the other.
        let (mut left, mut right) = (None, None);
        for side in collapse.sides(self.table.twin) {
            let arm = unit(self.x[self.table.vertex(side.apex) as usize] - from);
            if next(side.removed) == side.kept { left = Some(arm) } else { right = Some(arm) }
        }
        match (left, right) {
            (Some(a), Some(b)) => {
                let middle = a + b;
                if middle.dot(middle) < 1e-12 {
                    a.perp()
                } else if a.perp_dot(b) > 0.0 {
                    unit(middle)
                } else {
                    -unit(middle)
                }
            }
            (Some(a), None) => a.perp(),
            (None, Some(b)) => -b.perp(),
            (None, None) => DVec2::X,
        }
    }

    /// One Newton step of a node alone, kept where its energy falls.
    fn step(&mut self, node: u32, star: &Star) {
        let (mut gradient, mut xx, mut xy, mut yy) = (DVec2::ZERO, 0.0, 0.0, 0.0);
        for b in star {
            let (g, h) = b.rest.derivatives(b.nodes.map(|i| self.x[i as usize]));
            let [own_xx, own_xy, own_yy] = OWN_BLOCK[b.own].map(|entry| h[entry]);
            gradient += DVec2::new(g[2 * b.own], g[2 * b.own + 1]);
            (xx, xy, yy) = (xx + own_xx, xy + own_xy, yy + own_yy);
        }
        let det = xx * yy - xy * xy;
        if det.is_nan() || det <= 0.0 {
            return;
        }
        let step = DVec2::new(xy * gradient.y - yy * gradient.x, xy * gradient.x - xx * gradient.y) / det;
        let (from, slope) = (self.x[node as usize], step.dot(gradient));
        let now = self.energy(star, from);
        let mut length = 1.0;
        for _ in 0..SHORTER {
            let to = from + step * length;
            if self.energy(star, to) <= now + DECREASE * length * slope {
                self.x[node as usize] = to;
                return;
            }
            length *= SHORTEN;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use crate::base::workers::Serial;
    use std::vec;
    use std::vec::Vec;

    /// A chart of `side` x `side` cells over `height`, inner nodes first: positions, triangles, inner nodes, border in order.
    #[allow(clippy::type_complexity)]
    fn chart(side: u32, height: impl Fn(f64, f64) -> f64) -> (Vec<DVec3>, Vec<[u32; 3]>, usize, Vec<[u32; 2]>) {
        let n = side + 1;
        let is_inner = |v: u32| (1..side).contains(&(v % n)) && (1..side).contains(&(v / n));
        let mut number = vec![0; (n * n) as usize];
        let mut at = Vec::new();
        for inner in [true, false] {
            for v in (0..n * n).filter(|v| is_inner(*v) == inner) {
                number[v as usize] = at.len() as u32;
                let (x, y) = (f64::from(v % n) / f64::from(side), f64::from(v / n) / f64::from(side));
                at.push(DVec3::new(x, y, height(x, y)));
            }
        }
        let cells = (0..side * side).map(|i| i / side * n + i % side);
        let faces = cells.flat_map(|v| [[v, v + 1, v + n + 1], [v, v + n + 1, v + n]]);
        let triangles = faces.map(|f| f.map(|v| number[v as usize])).collect();
        let bottom = 0..side;
        let right = (0..side).map(|y| y * n + side);
        let top = (1..=side).rev().map(|x| side * n + x);
        let left = (1..=side).rev().map(|y| y * n);
        let round: Vec<u32> = bottom.chain(right).chain(top).chain(left).map(|v| number[v as usize]).collect();
        let border = (0..round.len()).map(|i| [round[i], round[(i + 1) % round.len()]]).collect();
        let inner = ((side - 1) * (side - 1)) as usize;
        (at, triangles, inner, border)
    }

    /// Energy over area of a chart that is flattened by levels or directly, and relaxed by one step; infinite where a triangle is turned.
    fn flattened(side: u32, height: impl Fn(f64, f64) -> f64, by_levels: bool) -> f64 {
        let (at, triangles, inner, border) = chart(side, height);
        let mut rest: Vec<Rest> = triangles.iter().map(|t| Rest::new(t.map(|i| at[i as usize]), MOLLIFY)).collect();
        even_out(&mut rest);
        let area: f64 = rest.iter().map(|r| r.area).sum();
        let piece = Piece { triangles: &triangles, rest: &rest, free: at.len(), at: &at, springs: &[], walls: &[] };
        let mut bytes = vec![0; 1 << 28];
        let mut scratch = Scratch::new(&mut bytes);
        let mut x = vec![DVec2::ZERO; at.len()];
        let steps = if by_levels {
            assert_eq!(flatten_by_levels(&mut x, &piece, inner, scratch.frame(), &Serial), Ok(true));
            1
        } else {
            tutte(&mut x, &piece, inner, &border, scratch.frame(), &Serial).unwrap();
            60
        };
        relax(&mut x, &piece, Stop { steps, tolerance: 1e-6 }, scratch, &Serial).unwrap().after / area
    }

    #[test]
    fn one_step_after_the_levels_is_as_good_as_sixty_from_a_circle() {
        let dome = |x: f64, y: f64| 0.8 * x * (1.0 - x) * y * (1.0 - y) * 4.0;
        let rough = |x: f64, y: f64| 0.3 * x * y + 0.004 * unit_f64(3, (x * 1e6) as u64, (y * 1e6) as u64);
        for (levels, direct) in [
            (flattened(70, dome, true), flattened(70, dome, false)),
            (flattened(70, rough, true), flattened(70, rough, false)),
        ] {
            // A thousandth of an isometry's energy is the tolerance of first maps.
            assert!(levels < direct + 4e-3, "{levels} {direct}");
        }
    }

    #[test]
    fn too_little_memory_is_an_error() {
        let (at, triangles, inner, _) = chart(60, |_, _| 0.0);
        let rest: Vec<Rest> = triangles.iter().map(|t| Rest::new(t.map(|i| at[i as usize]), MOLLIFY)).collect();
        let piece = Piece { triangles: &triangles, rest: &rest, free: at.len(), at: &at, springs: &[], walls: &[] };
        let mut x = vec![DVec2::ZERO; at.len()];
        assert!(flatten_by_levels(&mut x, &piece, inner, Scratch::new(&mut [0; 4096]), &Serial).is_err());
    }
}
