//! The sparse system of a piece: its triangles, springs and nodes, each added to the front it belongs to.

use super::piece::{Piece, Spring};
use super::sparse::dissection::Symbolic;
use super::sparse::front_matrix::FrontMatrix;
use super::sparse::multifrontal::Factor;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use glam::DVec2;

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

    /// Solves for another right-hand side with the matrix of the last [`solve`](Self::solve), at a tenth of its work; nothing where its
    /// factor is too large to be kept.
    pub fn solve_again(
        &mut self,
        x: &mut [DVec2],
        right: &[DVec2],
        scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<Option<f64>, ScratchTooSmall> {
        self.factor.solve_again(x, right, &self.symbolic, scratch, workers)
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

/// Adds a triangle's gradient, negated, and its 6 x 6 matrix (lower triangle, row by row) for its free nodes.
pub fn add_triangle(matrix: &mut FrontMatrix, nodes: [u32; 3], free: usize, g: &[f64; 6], h: &[f64; 21]) {
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
