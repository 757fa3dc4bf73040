//! One front of the multifrontal method: assembly, elimination, its update, and the way back down.
//!
//! A front is a dense lower triangle over the nodes that it eliminates and their border, beside it the right-hand side, which
//! is eliminated along with the matrix. Updates wait on a stack as packed triangles until their parent takes them.
//! Every sum has a fixed order.

use super::dense::partial_cholesky;
use super::dissection::Symbolic;
use super::front::Front;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use glam::DVec2;

/// Columns of a front that are assembled in one task: an even number, since a node has two.
const TASK: usize = 64;

/// Where a caller adds elements: one front at a time.
pub struct FrontMatrix<'m> {
    values: &'m mut [f64], // (size, size) by columns, lower triangle
    vector: &'m mut [f64], // (size)
    local: &'m [u32],      // (n) place of a node in this front
    size: usize,
}

impl FrontMatrix<'_> {
    /// Adds a 2 x 2 block (row-major) at (node `i`, node `j`); for i != j the transposed block is implied.
    #[inline]
    pub fn add(&mut self, i: u32, j: u32, block: [f64; 4]) {
        let (r, c) = (self.local[i as usize] as usize, self.local[j as usize] as usize);
        let (r, c, block) = if r >= c { (r, c, block) } else { (c, r, [block[0], block[2], block[1], block[3]]) };
        let (low, high) = (2 * c * self.size + 2 * r, (2 * c + 1) * self.size + 2 * r);
        self.values[low] += block[0];
        self.values[low + 1] += block[2];
        self.values[high] += block[1];
        self.values[high + 1] += block[3];
    }

    /// Adds to the right-hand side at node `i`.
    #[inline]
    pub fn add_vector(&mut self, i: u32, value: DVec2) {
        let r = 2 * self.local[i as usize] as usize;
        self.vector[r] += value.x;
        self.vector[r + 1] += value.y;
    }
}

/// What adds the elements of a front.
pub(super) type AddElements<'f> = &'f (dyn Fn(u32, &mut FrontMatrix) + Sync);

/// Updates of finished fronts whose parent is still to come.
pub(super) struct Updates<'a> {
    values: &'a mut [f64],
    top: usize,
    waiting: heapless::Vec<u32, 128>,
}

impl<'a> Updates<'a> {
    /// An empty stack for `len` values.
    pub fn new(len: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self { values: scratch.take_unset(len)?, top: 0, waiting: heapless::Vec::new() })
    }

    /// Puts the update of front `f` on top; `write` fills it.
    pub fn push(&mut self, f: usize, front: &Front, write: impl FnOnce(&mut [f64])) {
        let end = self.top + front.update_len();
        write(&mut self.values[self.top..end]);
        self.top = end;
        self.waiting.put(f as u32);
    }

    /// Takes the one on top.
    pub fn pop<'s>(&'s mut self, symbolic: &Symbolic) -> Option<(Front, &'s [f64])> {
        let child = symbolic.fronts[self.waiting.pop()? as usize];
        let end = self.top;
        self.top -= child.update_len();
        Some((child, &self.values[self.top..end]))
    }
}

/// Memory of one front at a time.
pub(super) struct Bench<'a> {
    matrix: &'a mut [f64],
    vector: &'a mut [f64],
    local: &'a mut [u32], // (n)
    /// Side of the front at work, and how many of its columns are eliminated.
    m: usize,
    own: usize,
}

impl<'a> Bench<'a> {
    /// Memory for fronts of up to `side` unknowns in a system of `nodes` nodes.
    pub fn new(side: usize, nodes: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let matrix = scratch.take_unset(side * side)?;
        let vector = scratch.take_unset(side)?;
        Ok(Self { matrix, vector, local: scratch.take_unset(nodes)?, m: 0, own: 0 })
    }

    /// Assembles front `f` from its elements and its children's updates, and eliminates its columns.
    pub fn eliminate(
        &mut self,
        f: usize,
        symbolic: &Symbolic,
        updates: &mut Updates,
        add: AddElements,
        workers: &dyn Workers,
    ) {
        let front = &symbolic.fronts[f];
        let (m, own) = (front.size(), front.own());
        (self.m, self.own) = (m, own);
        let (values, vector) = (&mut self.matrix[..m * m], &mut self.vector[..m]);
        // Nobody reads what is above the diagonal.
        values.rows_mut(m).enumerate().for_each(|(c, column)| column[c..].fill(0.0));
        vector.fill(0.0);
        for (k, node) in symbolic.own_nodes(f).iter().enumerate() {
            self.local[*node as usize] = k as u32;
        }
        for (k, p) in symbolic.border[front.border_range()].iter().enumerate() {
            self.local[symbolic.order[*p as usize] as usize] = front.count + k as u32;
        }
        add(f as u32, &mut FrontMatrix { values, vector, local: self.local, size: m });
        for _ in 0..front.children {
            if let Some((child, update)) = updates.pop(symbolic) {
                extend_add(values, vector, update, &child, symbolic, self.local, workers);
            }
        }
        partial_cholesky(values, m, own, workers);
        for c in 0..own {
            let column = &values[c * m..(c + 1) * m];
            let (done, below) = vector.parted_mut(c + 1);
            done[c] /= column[c];
            below.iter_mut().zip(&column[c + 1..]).for_each(|(v, l)| *v -= done[c] * l);
        }
    }

    /// The right-hand side of the unknowns that were eliminated: L^-1 of what it was.
    pub fn solved(&self) -> &[f64] {
        &self.vector[..self.own]
    }

    /// Writes the columns in single precision, each from the diagonal down.
    pub fn write_columns(&self, out: &mut [f32]) {
        let mut at = 0;
        for c in 0..self.own {
            let column = &self.matrix[c * self.m + c..(c + 1) * self.m];
            out[at..at + column.len()].iter_mut().zip(column).for_each(|(o, l)| *o = *l as f32);
            at += column.len();
        }
    }

    /// Writes the update.
    pub fn write_update(&self, out: &mut [f64]) {
        let mut at = 0;
        for c in self.own..self.m {
            let column = &self.matrix[c * self.m + c..(c + 1) * self.m];
            out[at..at + column.len()].copy_from(column);
            at += column.len();
        }
        out[at..].copy_from(&self.vector[self.own..self.m]);
    }
}

/// Adds a child's update to its parent's front.
fn extend_add(
    values: &mut [f64],
    vector: &mut [f64],
    update: &[f64],
    child: &Front,
    symbolic: &Symbolic,
    local: &[u32],
    workers: &dyn Workers,
) {
    let m = vector.len();
    let border = &symbolic.border[child.border_range()];
    let place = |p: &u32| 2 * local[symbolic.order[*p as usize] as usize] as usize;
    for_each_chunk(workers, values, TASK * m, &|task, columns| {
        let begin = task * TASK;
        let skipped = border.partition_point(|p| place(p) < begin);
        // The columns before hold 4 n - 1 values each, n the nodes from there on.
        let mut rest = &update[skipped * (4 * border.len() + 1 - 2 * skipped)..];
        for (c, p) in border.iter().enumerate().skip(skipped) {
            let to = place(p);
            if to >= begin + TASK {
                break;
            }
            let side = 2 * (border.len() - c);
            let (first, second) = (&rest[..side], &rest[side..2 * side - 1]);
            rest = &rest[2 * side - 1..];
            let (head, tail) = columns[(to - begin) * m..].parted_mut(m);
            head[to] += first[0];
            head[to + 1] += first[1];
            tail[to + 1] += second[0];
            // Borders ascend and so do the parent's places: row >= column holds there too.
            let pairs = first[2..].as_chunks::<2>().0.iter().zip(second[1..].as_chunks::<2>().0);
            for (p, (a, b)) in border[c + 1..].iter().zip(pairs) {
                let row = place(p);
                head[row] += a[0];
                head[row + 1] += a[1];
                tail[row] += b[0];
                tail[row + 1] += b[1];
            }
        }
    });
    let at = update.len() - 2 * border.len();
    for (p, pair) in border.iter().zip(update[at..].as_chunks::<2>().0) {
        let row = place(p);
        vector[row] += pair[0];
        vector[row + 1] += pair[1];
    }
}

/// Replaces b by L^-1 b for the unknowns of a front whose earlier ones are done, and takes their share off its border's. `y` stands by
/// position; `part` is memory.
pub(super) fn forward(y: &mut [f64], front: &Front, columns: &[f32], symbolic: &Symbolic, part: &mut [f64]) {
    let (m, own, first) = (front.size(), front.own(), 2 * front.first as usize);
    part[..own].copy_from(&y[first..first + own]);
    part[own..m].fill(0.0);
    let mut rest = columns;
    for c in 0..own {
        let Some((column, others)) = rest.split_at_checked(m - c) else { return };
        rest = others;
        let (done, below) = part[..m].parted_mut(c + 1);
        done[c] /= f64::from(column[0]);
        below.iter_mut().zip(&column[1..]).for_each(|(p, l)| *p -= done[c] * f64::from(*l));
    }
    y[first..first + own].copy_from(&part[..own]);
    for (k, p) in symbolic.border[front.border_range()].iter().enumerate() {
        let at = 2 * *p as usize;
        y[at] += part[own + 2 * k];
        y[at + 1] += part[own + 2 * k + 1];
    }
}

/// Unknowns by position: a run of them that may change, and others that may only be read.
pub(super) struct Unknowns<'v> {
    /// Position of the first.
    pub first: usize,
    pub own: &'v mut [f64],
    /// Positions of the others, ascending, and two values each.
    pub far_at: &'v [u32],
    pub far: &'v [f64],
}

impl Unknowns<'_> {
    fn get(&self, position: u32) -> [f64; 2] {
        let at = 2 * (position as usize - self.first);
        match self.own.get(at..at + 2) {
            Some(pair) => [pair[0], pair[1]],
            None => {
                let k = self.far_at.partition_point(|p| *p < position);
                [self.far[2 * k], self.far[2 * k + 1]]
            }
        }
    }

    /// Replaces L^-1 b by L^-T L^-1 b for the unknowns of a front whose later ones are solved. `part` is memory.
    pub fn back(&mut self, front: &Front, columns: &[f32], symbolic: &Symbolic, part: &mut [f64]) {
        let (m, own) = (front.size(), front.own());
        let first = 2 * (front.first as usize - self.first);
        part[..own].copy_from(&self.own[first..first + own]);
        for (k, p) in symbolic.border[front.border_range()].iter().enumerate() {
            part[own + 2 * k..own + 2 * k + 2].copy_from(&self.get(*p));
        }
        let mut end = front.column_len();
        for c in (0..own).rev() {
            let column = &columns[end - (m - c)..end];
            end -= m - c;
            let mut sums = [0.0; 4];
            let mut add = |p: &[f64], l: &[f32]| {
                for ((s, p), l) in sums.iter_mut().zip(p).zip(l) {
                    *s += p * f64::from(*l);
                }
            };
            let ((fours, rest), (column_fours, column_rest)) =
                (part[c + 1..m].as_chunks::<4>(), column[1..].as_chunks::<4>());
            fours.iter().zip(column_fours).for_each(|(p, l)| add(p, l));
            add(rest, column_rest);
            part[c] = (part[c] - ((sums[0] + sums[1]) + (sums[2] + sums[3]))) / f64::from(column[0]);
        }
        self.own[first..first + own].copy_from(&part[..own]);
    }
}
