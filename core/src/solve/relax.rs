//! Newton's method on the symmetric Dirichlet energy of a piece of surface, and the springs that pull it.
//!
//! Projected Newton: per-triangle Hessians made positive semi-definite (`energy`), one direct solve a step (`sparse`),
//! a step length that keeps every triangle's orientation, then backtracking to a sufficient decrease.
//! Guarantee: a start without flips stays without flips, and the energy never rises.
//! Cost: O(n^1.5) a step for n nodes; the order and the fronts are found once a call.

use super::piece::{Piece, Spring, Stop};
use super::sparse::dissection::Symbolic;
use super::sparse::front_matrix::FrontMatrix;
use super::sparse::multifrontal::Factor;
use super::walls::{Walls, walls_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use glam::{DVec2, DVec3};

/// Share of the largest flip-free step that is taken. 0.99 lets triangles come so close to flat that later steps stall.
const STEP_SHARE: f64 = 0.8;
/// Sufficient decrease (Armijo).
const DECREASE: f64 = 1e-4;
/// Added to each diagonal entry: holds the rigid motions, which have no energy.
const HOLD: f64 = 1e-7;

/// Triangles whose energies are summed by one task.
const CHUNK: usize = 2048;

/// Share of the least decrease below which charts count as settled without a look at the whole. Of 24 charts of 30,000
/// nodes that a split had changed little, 0.3 spares 12 of 15 factorisations that found nothing to do and skips one step of
/// 9; 0.2 spares 7 and skips none.
const SETTLED: f64 = 0.3;
/// Smaller charts are factored anyway.
const SETTLED_FROM: usize = 2000;

/// What was done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Relaxation {
    /// Energy of triangles and springs at the start.
    pub before: f64,
    /// And at the end.
    pub after: f64,
    /// Newton steps taken.
    pub steps: usize,
    /// Whether the tolerance was reached.
    pub converged: bool,
}

/// Graph, order, fronts and the elements of each front.
pub struct System<'a> {
    symbolic: Symbolic<'a>,
    triangle_start: &'a [u32], // (fronts + 1)
    triangles: &'a [u32],
    spring_start: &'a [u32], // (fronts + 1)
    springs: &'a [u32],
    factor: Factor<'a>,
}

impl<'a> System<'a> {
    /// Prepares the systems of a piece. `temporary` holds [`graph_need`] bytes.
    pub fn new(piece: &Piece, keep: &mut Scratch<'a>, mut temporary: Scratch) -> Result<Self, ScratchTooSmall> {
        let free = piece.free as u32;
        let start = temporary.take::<u32>(piece.free + 1)?;
        let edges = || {
            let of_triangles = piece
                .triangles
                .iter()
                .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
                .flat_map(|(a, b)| [(a, b), (b, a)]);
            let of_springs = piece.springs.iter().flat_map(|s| [(s.a, s.b), (s.b, s.a)]);
            of_triangles.chain(of_springs).filter(|(a, b)| *a < free && *b < free)
        };
        for (a, _) in edges() {
            start[a as usize + 1] += 1;
        }
        for i in 0..piece.free {
            start[i + 1] += start[i];
        }
        let neighbours = temporary.take::<u32>(start[piece.free] as usize)?;
        {
            let mut frame = temporary.frame();
            let at = frame.take::<u32>(piece.free)?;
            at.copy_from(&start[..piece.free]);
            for (a, b) in edges() {
                neighbours[at[a as usize] as usize] = b;
                at[a as usize] += 1;
            }
        }
        let symbolic = Symbolic::new(start, neighbours, &piece.at[..piece.free], keep, temporary)?;
        let (triangle_start, triangles) = bucket(&symbolic, piece.triangles.len(), keep, |t| {
            symbolic.front_of_element(piece.triangles[t].iter().copied().filter(|i| *i < free))
        })?;
        let (spring_start, springs) = bucket(&symbolic, piece.springs.len(), keep, |s| {
            symbolic.front_of_element([piece.springs[s].a, piece.springs[s].b].into_iter().filter(|i| *i < free))
        })?;
        let factor = Factor::new(&symbolic, keep)?;
        Ok(Self { symbolic, triangle_start, triangles, spring_start, springs, factor })
    }

    /// Solves for `x`: `triangle(t, matrix)`, `spring(s, matrix)` and `node(i, matrix)` add the elements and their right-hand
    /// sides. Returns the right-hand side times `x`.
    pub fn solve(
        &mut self,
        x: &mut [DVec2],
        triangle: impl Fn(usize, &mut FrontMatrix) + Sync,
        spring: impl Fn(usize, &mut FrontMatrix) + Sync,
        node: impl Fn(u32, &mut FrontMatrix) + Sync,
        scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<f64, ScratchTooSmall> {
        let Self { symbolic, triangle_start, triangles, spring_start, springs, factor } = self;
        let add = |f: u32, matrix: &mut FrontMatrix| {
            let f = f as usize;
            for t in &triangles[triangle_start[f] as usize..triangle_start[f + 1] as usize] {
                triangle(*t as usize, matrix);
            }
            for s in &springs[spring_start[f] as usize..spring_start[f + 1] as usize] {
                spring(*s as usize, matrix);
            }
            for i in symbolic.own_nodes(f) {
                node(*i, matrix);
            }
        };
        factor.solve(x, symbolic, &add, scratch, workers)
    }
}

/// Temporary bytes for [`System::new`].
pub fn graph_need(piece: &Piece) -> usize {
    (piece.free + 6 * piece.triangles.len() + 2 * piece.springs.len()) * 4 + piece.free * 16 + 256
}

/// Sorts elements into the fronts they belong to; elements without a free node are left out.
fn bucket<'a>(
    symbolic: &Symbolic,
    count: usize,
    keep: &mut Scratch<'a>,
    front: impl Fn(usize) -> Option<u32>,
) -> Result<(&'a [u32], &'a [u32]), ScratchTooSmall> {
    let start = keep.take::<u32>(symbolic.front_count() + 2)?;
    let list = keep.take::<u32>(count)?;
    for e in 0..count {
        if let Some(f) = front(e) {
            start[f as usize + 2] += 1;
        }
    }
    for f in 2..start.len() {
        start[f] += start[f - 1];
    }
    for e in 0..count {
        if let Some(f) = front(e) {
            list[start[f as usize + 1] as usize] = e as u32;
            start[f as usize + 1] += 1;
        }
    }
    Ok((start, list))
}

/// Scratch bytes for [`relax`] or a [`System`] on this many nodes, triangles and springs. The factor's size depends on
/// the graph: measured on charts of 400 to 50,000 nodes it is 15 to 23 log2(n) values a node; 32 log2(n) + 64 are held.
pub fn relax_need(nodes: usize, triangles: usize, springs: usize) -> usize {
    let log = (usize::BITS - nodes.leading_zeros()) as usize;
    let factor = nodes * (32 * log + 64) * 4;
    let fronts = nodes * (110 + 144) * 8 + 200_000;
    let graph = nodes * 190 + triangles * 40 + springs * 48;
    factor + fronts + graph + 4096 + walls_need(nodes)
}

/// Energy of a piece at `x`: triangles (psi times area) and springs. `sums` is memory, one value a chunk.
fn energy(piece: &Piece, x: &[DVec2], sums: &mut [f64], workers: &dyn Workers) -> f64 {
    for_each_chunk(workers, sums, 1, &|chunk, sum| {
        let range = chunk_of(chunk, piece.triangles.len());
        let pairs = piece.triangles[range.clone()].iter().zip(&piece.rest[range]);
        sum[0] = pairs.map(|(t, rest)| rest.weight * rest.objective(t.map(|i| x[i as usize]))).sum();
    });
    let mut sum = sums.iter().sum();
    for s in piece.springs {
        let d = x[s.a as usize] - x[s.b as usize];
        sum += s.weight * d.dot(d);
    }
    sum
}

/// Triangles of a chunk.
fn chunk_of(chunk: usize, count: usize) -> core::ops::Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(count)
}

/// Moves the free nodes of `x` to lower energy. A start with a flipped triangle is returned as it is, with infinite
/// energy.
pub fn relax(
    x: &mut [DVec2],
    piece: &Piece,
    stop: Stop,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<Relaxation, ScratchTooSmall> {
    let free = piece.free;
    let sums = scratch.take::<f64>(piece.triangles.len().div_ceil(CHUNK))?;
    let mut walls = Walls::new(piece.walls, piece, &mut scratch)?;
    let pushes = scratch.take::<[f64; 5]>(if piece.walls.is_empty() { 0 } else { x.len() })?;
    walls.open(x, piece, scratch.frame())?;
    let mut now = energy(piece, x, sums, workers) + walls.energy(x);
    let mut done = Relaxation { before: now, after: now, ..Relaxation::default() };
    if free == 0 || now == f64::INFINITY || stop.steps == 0 {
        return Ok(done);
    }
    let area: f64 = piece.rest.iter().map(|r| r.area).sum();
    if settled(x, piece, stop.tolerance * area, scratch.frame())? {
        done.converged = true;
        return Ok(done);
    }
    // What only the order of elimination needs serves the steps afterwards.
    let bytes = bytes_for::<DVec3>(free) + graph_need(piece);
    let mut spare = scratch.split(bytes.max(2 * bytes_for::<DVec2>(x.len())))?;
    let mut system = {
        let mut frame = spare.frame();
        // The map is an embedding of the graph in the plane: short separators, whatever the surface does in space.
        let at = frame.take::<DVec3>(free)?;
        at.iter_mut().zip(x.iter()).for_each(|(a, x)| *a = x.extend(0.0));
        System::new(&Piece { at, ..*piece }, &mut scratch, frame)?
    };
    let step = spare.take::<DVec2>(x.len())?; // held nodes keep a zero step
    let trial = spare.take::<DVec2>(x.len())?;
    trial.copy_from(x);
    while done.steps < stop.steps {
        let here = &*x;
        walls.derivatives(here, pushes);
        let held = &*pushes;
        let fall = system.solve(
            &mut step[..free],
            |t, matrix| {
                let nodes = piece.triangles[t];
                let (g, h) = piece.rest[t].derivatives(nodes.map(|i| here[i as usize]));
                add_triangle(matrix, nodes, free, &g, &h);
            },
            |s, matrix| {
                let s = piece.springs[s];
                add_spring(matrix, s, free);
                add_pull(matrix, s, (here[s.b as usize] - here[s.a as usize]) * (2.0 * s.weight), free);
            },
            |i, matrix| {
                let [gx, gy, xx, xy, yy] = held.get(i as usize).copied().unwrap_or_default();
                matrix.add(i, i, [xx + HOLD, xy, xy, yy + HOLD]);
                matrix.add_vector(i, -DVec2::new(gx, gy));
            },
            scratch.frame(),
            workers,
        )?;
        // The step is -H^-1 g: it falls by g . H^-1 g.
        let slope = -fall;
        if slope.is_nan() || slope > -stop.tolerance * area {
            done.converged = true;
            break;
        }
        let ahead = &*step;
        for_each_chunk(workers, sums, 1, &|chunk, limit| {
            let range = chunk_of(chunk, piece.triangles.len());
            limit[0] = 1.0 / STEP_SHARE;
            for (t, rest) in piece.triangles[range.clone()].iter().zip(&piece.rest[range]) {
                limit[0] = rest.step_limit(t.map(|i| here[i as usize]), t.map(|i| ahead[i as usize]), limit[0]);
            }
        });
        let limit = sums.iter().copied().fold(1.0 / STEP_SHARE, f64::min);
        let limit = walls.limit(here, ahead, limit);
        let mut length = (limit * STEP_SHARE).min(1.0);
        let mut found = false;
        for _ in 0..30 {
            for i in 0..free {
                trial[i] = x[i] + step[i] * length;
            }
            let next = energy(piece, trial, sums, workers) + walls.energy(trial);
            if next <= now + DECREASE * length * slope {
                found = true;
                now = next;
                break;
            }
            length *= 0.5;
        }
        done.steps += 1;
        if !found {
            break;
        }
        x[..free].copy_from(&trial[..free]);
    }
    done.after = now;
    Ok(done)
}

/// Whether a step promises next to nothing, told without a factorisation: the decrease that each node alone could reach,
/// g . D^-1 g with D the 2 x 2 blocks on the diagonal, is well below `least`.
fn settled(x: &[DVec2], piece: &Piece, least: f64, mut scratch: Scratch) -> Result<bool, ScratchTooSmall> {
    if !piece.springs.is_empty() || !piece.walls.is_empty() || piece.free < SETTLED_FROM {
        return Ok(false);
    }
    let sums = scratch.take::<[f64; 5]>(x.len())?; // gradient, and a block's xx, xy, yy
    for (t, rest) in piece.triangles.iter().zip(piece.rest) {
        let (g, h) = rest.derivatives(t.map(|i| x[i as usize]));
        for (k, (i, block)) in t.iter().zip([[0, 1, 2], [5, 8, 9], [14, 19, 20]]).enumerate() {
            let sum = &mut sums[*i as usize];
            sum[0] += g[2 * k];
            sum[1] += g[2 * k + 1];
            for (s, entry) in sum[2..].iter_mut().zip(block) {
                *s += h[entry];
            }
        }
    }
    let mut fall = 0.0;
    for [gx, gy, xx, xy, yy] in &sums[..piece.free] {
        let det = xx * yy - xy * xy;
        fall += (yy * gx * gx - 2.0 * xy * gx * gy + xx * gy * gy) / det.max(f64::MIN_POSITIVE);
    }
    Ok(fall < SETTLED * least)
}

/// Adds a triangle's gradient, negated, and its 6 x 6 matrix (lower triangle, row by row) for its free nodes.
fn add_triangle(matrix: &mut FrontMatrix, nodes: [u32; 3], free: usize, g: &[f64; 6], h: &[f64; 21]) {
    let entry = |r: usize, c: usize| if r >= c { h[r * (r + 1) / 2 + c] } else { h[c * (c + 1) / 2 + r] };
    for i in 0..3 {
        if (nodes[i] as usize) < free {
            matrix.add_vector(nodes[i], -DVec2::new(g[2 * i], g[2 * i + 1]));
        }
        for j in 0..=i {
            if (nodes[i] as usize) < free && (nodes[j] as usize) < free {
                let (r, c) = (2 * i, 2 * j);
                let block = [entry(r, c), entry(r, c + 1), entry(r + 1, c), entry(r + 1, c + 1)];
                matrix.add(nodes[i], nodes[j], block);
            }
        }
    }
}

/// Adds a spring's matrix for its free ends.
pub fn add_spring(matrix: &mut FrontMatrix, spring: Spring, free: usize) {
    let w = 2.0 * spring.weight;
    let (a, b) = ((spring.a as usize) < free, (spring.b as usize) < free);
    if a {
        matrix.add(spring.a, spring.a, [w, 0.0, 0.0, w]);
    }
    if b {
        matrix.add(spring.b, spring.b, [w, 0.0, 0.0, w]);
    }
    if a && b {
        matrix.add(spring.a, spring.b, [-w, 0.0, 0.0, -w]);
    }
}

/// Adds the pull of a spring to the right-hand side of its free ends: `pull` on the first, the opposite on the second.
pub fn add_pull(matrix: &mut FrontMatrix, spring: Spring, pull: DVec2, free: usize) {
    for (i, force) in [(spring.a, pull), (spring.b, -pull)] {
        if (i as usize) < free {
            matrix.add_vector(i, force);
        }
    }
}
