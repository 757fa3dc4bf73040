//! The multifrontal method (Duff, Reid 1983; Liu 1992): dense fronts along the dissection's tree.
//!
//! No global matrix is stored: a caller adds each element's matrix to the front in which its first node is eliminated.
//! Work is O(n^1.5) for n nodes of a planar graph. Every sum has a fixed order.
//! The factor is kept in f32, half the memory: its solution is a direction, which a line search or a second round
//! corrects.

use super::dense::partial_cholesky;
use super::dissection::{Front, Symbolic};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::vector::wide;
use glam::DVec2;

/// Where a caller adds element matrices: one front at a time.
pub struct FrontMatrix<'m> {
    values: &'m mut [f64], // (size, size) by columns, lower triangle
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
}

/// A factored system.
pub struct Factor<'a> {
    values: &'a mut [f32],
}

impl<'a> Factor<'a> {
    /// Memory for the factor of `symbolic`.
    pub fn new(symbolic: &Symbolic, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self { values: keep.take(symbolic.factor_len)? })
    }

    /// Factors the sum of all elements: `add(front, matrix)` adds those of each front.
    pub fn factor(
        &mut self,
        symbolic: &Symbolic,
        mut add: impl FnMut(u32, &mut FrontMatrix),
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let stack = scratch.take::<f64>(symbolic.stack_len)?;
        let buffer = scratch.take::<f64>(symbolic.front_size * symbolic.front_size)?;
        let local = scratch.take::<u32>(symbolic.order.len())?; // by node
        let mut waiting = heapless::Vec::<u32, 128>::new();
        let mut top = 0;
        for (f, front) in symbolic.fronts.iter().enumerate() {
            let m = front.size();
            let own = 2 * front.count as usize;
            let values = &mut buffer[..m * m];
            values.fill(0.0);
            let border = &symbolic.border[front.border as usize..(front.border + front.border_len) as usize];
            for k in 0..front.count {
                local[symbolic.order[(front.first + k) as usize] as usize] = k;
            }
            for (k, p) in border.iter().enumerate() {
                local[symbolic.order[*p as usize] as usize] = front.count + k as u32;
            }
            add(f as u32, &mut FrontMatrix { values, local, size: m });
            for _ in 0..front.children {
                let Some(child) = waiting.pop() else { break };
                let child = &symbolic.fronts[child as usize];
                let side = 2 * child.border_len as usize;
                top -= side * side;
                extend_add(values, m, &stack[top..top + side * side], child, symbolic, local);
            }
            wide(
                #[inline(always)]
                || partial_cholesky(values, m, own),
            );
            let at = front.factor as usize;
            for (kept, value) in self.values[at..at + own * m].iter_mut().zip(values.iter()) {
                *kept = *value as f32;
            }
            let side = m - own;
            for c in 0..side {
                let from = (own + c) * m + own;
                stack[top + c * side + c..top + (c + 1) * side].copy_from_slice(&values[from + c..from + side]);
            }
            top += side * side;
            waiting.push(f as u32).ok();
        }
        Ok(())
    }

    /// Replaces `x` (one value pair a node: the right-hand side) by the solution.
    pub fn solve(&self, symbolic: &Symbolic, x: &mut [DVec2], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
        let y = scratch.take::<f64>(2 * x.len())?; // by position
        for (position, node) in symbolic.order.iter().enumerate() {
            y[2 * position] = x[*node as usize].x;
            y[2 * position + 1] = x[*node as usize].y;
        }
        let part = scratch.take::<f64>(symbolic.front_size)?;
        for front in symbolic.fronts {
            let (m, own) = (front.size(), 2 * front.count as usize);
            let columns = &self.values[front.factor as usize..front.factor as usize + own * m];
            gather(part, y, front, symbolic);
            for c in 0..own {
                let column = &columns[c * m..(c + 1) * m];
                let value = part[c] / f64::from(column[c]);
                part[c] = value;
                for (p, l) in part[c + 1..m].iter_mut().zip(&column[c + 1..]) {
                    *p -= value * f64::from(*l);
                }
            }
            spread(y, part, front, symbolic);
        }
        for front in symbolic.fronts.iter().rev() {
            let (m, own) = (front.size(), 2 * front.count as usize);
            let columns = &self.values[front.factor as usize..front.factor as usize + own * m];
            gather(part, y, front, symbolic);
            for c in (0..own).rev() {
                let column = &columns[c * m..(c + 1) * m];
                let mut sums = [0.0; 4];
                for (p, l) in part[c + 1..m].chunks(4).zip(column[c + 1..].chunks(4)) {
                    for ((s, p), l) in sums.iter_mut().zip(p).zip(l) {
                        *s += p * f64::from(*l);
                    }
                }
                part[c] = (part[c] - ((sums[0] + sums[1]) + (sums[2] + sums[3]))) / f64::from(column[c]);
            }
            let first = 2 * front.first as usize;
            y[first..first + own].copy_from_slice(&part[..own]);
        }
        for (position, node) in symbolic.order.iter().enumerate() {
            x[*node as usize] = DVec2::new(y[2 * position], y[2 * position + 1]);
        }
        Ok(())
    }
}

fn gather(part: &mut [f64], y: &[f64], front: &Front, symbolic: &Symbolic) {
    let (first, own) = (2 * front.first as usize, 2 * front.count as usize);
    part[..own].copy_from_slice(&y[first..first + own]);
    let border = &symbolic.border[front.border as usize..(front.border + front.border_len) as usize];
    for (k, p) in border.iter().enumerate() {
        part[own + 2 * k] = y[2 * *p as usize];
        part[own + 2 * k + 1] = y[2 * *p as usize + 1];
    }
}

fn spread(y: &mut [f64], part: &[f64], front: &Front, symbolic: &Symbolic) {
    let (first, own) = (2 * front.first as usize, 2 * front.count as usize);
    y[first..first + own].copy_from_slice(&part[..own]);
    let border = &symbolic.border[front.border as usize..(front.border + front.border_len) as usize];
    for (k, p) in border.iter().enumerate() {
        y[2 * *p as usize] = part[own + 2 * k];
        y[2 * *p as usize + 1] = part[own + 2 * k + 1];
    }
}

/// Adds a child's update (lower triangle, by columns) to its parent's front.
fn extend_add(values: &mut [f64], m: usize, update: &[f64], child: &Front, symbolic: &Symbolic, local: &[u32]) {
    let side = 2 * child.border_len as usize;
    let border = &symbolic.border[child.border as usize..(child.border + child.border_len) as usize];
    let place = |k: usize| local[symbolic.order[border[k] as usize] as usize] as usize;
    for c in 0..border.len() {
        let to = place(c);
        let column = 2 * to * m;
        let from = 2 * c * side;
        let (from_next, column_next) = (from + side, column + m);
        values[column + 2 * to] += update[from + 2 * c];
        values[column + 2 * to + 1] += update[from + 2 * c + 1];
        values[column_next + 2 * to + 1] += update[from_next + 2 * c + 1];
        for r in c + 1..border.len() {
            // Borders ascend and so do the parent's places: row >= column holds there too.
            let row = 2 * place(r);
            values[column + row] += update[from + 2 * r];
            values[column + row + 1] += update[from + 2 * r + 1];
            values[column_next + row] += update[from_next + 2 * r];
            values[column_next + row + 1] += update[from_next + 2 * r + 1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use glam::DVec3;
    use std::{vec, vec::Vec};

    /// A grid graph of side x side nodes, and its springs.
    #[allow(clippy::type_complexity)]
    fn grid(side: usize) -> (Vec<DVec3>, Vec<(u32, u32, f64)>, Vec<u32>, Vec<u32>) {
        let mut at = Vec::new();
        let mut springs = Vec::new();
        for y in 0..side {
            for x in 0..side {
                let i = (y * side + x) as u32;
                at.push(DVec3::new(x as f64, y as f64, 0.0));
                if x + 1 < side {
                    springs.push((i, i + 1, 1.0 + unit_f64(1, 1, springs.len() as u64)));
                }
                if y + 1 < side {
                    springs.push((i, i + side as u32, 1.0 + unit_f64(1, 1, springs.len() as u64)));
                }
            }
        }
        let mut lists = vec![Vec::new(); at.len()];
        for (a, b, _) in &springs {
            lists[*a as usize].push(*b);
            lists[*b as usize].push(*a);
        }
        let mut start = vec![0];
        let mut neighbours = Vec::new();
        for list in lists {
            neighbours.extend(list);
            start.push(neighbours.len() as u32);
        }
        (at, springs, start, neighbours)
    }

    #[test]
    fn the_solution_satisfies_the_system() {
        for side in [1, 2, 5, 17, 40] {
            let (at, springs, start, neighbours) = grid(side);
            let n = at.len();
            let mut bytes = vec![0u8; 20_000_000];
            let mut scratch = Scratch::new(&mut bytes);
            let temporary = scratch.split(4_000_000).unwrap();
            let symbolic = Symbolic::new(&start, &neighbours, &at, &mut scratch, temporary).unwrap();
            let mut factor = Factor::new(&symbolic, &mut scratch).unwrap();
            let mut lists = vec![Vec::new(); symbolic.front_count()];
            for s in &springs {
                lists[symbolic.front_of_element([s.0, s.1].into_iter()).unwrap() as usize].push(*s);
            }
            let mut diagonal = vec![Vec::new(); symbolic.front_count()];
            for i in 0..n as u32 {
                diagonal[symbolic.front_of_element([i].into_iter()).unwrap() as usize].push(i);
            }
            let add = |f: u32, matrix: &mut FrontMatrix| {
                for (a, b, w) in &lists[f as usize] {
                    matrix.add(*a, *a, [*w, 0.0, 0.0, *w]);
                    matrix.add(*b, *b, [*w, 0.0, 0.0, *w]);
                    matrix.add(*a, *b, [-*w, 0.1, 0.0, -*w]);
                }
                for i in &diagonal[f as usize] {
                    matrix.add(*i, *i, [0.5, 0.1, 0.1, 0.5]);
                }
            };
            factor.factor(&symbolic, add, scratch.frame()).unwrap();
            let rhs: Vec<DVec2> =
                (0..n).map(|i| DVec2::new(unit_f64(2, 0, i as u64), unit_f64(2, 1, i as u64))).collect();
            let mut x = rhs.clone();
            factor.solve(&symbolic, &mut x, scratch.frame()).unwrap();
            let mut product = vec![DVec2::ZERO; n];
            for (i, p) in product.iter_mut().enumerate() {
                *p = DVec2::new(0.5 * x[i].x + 0.1 * x[i].y, 0.1 * x[i].x + 0.5 * x[i].y);
            }
            for (a, b, w) in &springs {
                let (a, b) = (*a as usize, *b as usize);
                product[a] += (x[a] - x[b]) * *w + DVec2::new(0.1 * x[b].y, 0.0);
                product[b] += (x[b] - x[a]) * *w + DVec2::new(0.0, 0.1 * x[a].x);
            }
            // The factor is kept in single precision: residual below n_row eps |L| |L^T| |x|, here 7 x 6e-8 x 20 x 2.
            for i in 0..n {
                assert!((product[i] - rhs[i]).length() < 2e-5, "{side} {i}");
            }
        }
    }

    #[test]
    fn an_empty_graph_is_solved() {
        let mut bytes = vec![0u8; 100_000];
        let mut scratch = Scratch::new(&mut bytes);
        let temporary = scratch.split(1000).unwrap();
        let symbolic = Symbolic::new(&[0], &[], &[], &mut scratch, temporary).unwrap();
        let mut factor = Factor::new(&symbolic, &mut scratch).unwrap();
        factor.factor(&symbolic, |_, _| {}, scratch.frame()).unwrap();
        assert_eq!(factor.solve(&symbolic, &mut [], scratch.frame()), Ok(()));
    }
}
