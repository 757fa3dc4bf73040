//! The multifrontal method (Duff, Reid 1983; Liu 1992): dense fronts along the dissection's tree.
//!
//! No global matrix is stored: a caller adds each element's matrix and right-hand side to the front in which its first node
//! is eliminated. Work is O(n^1.5) for n nodes of a planar graph. Boughs are eliminated side by side, the fronts above them
//! one after the other with their columns shared out; the bits are the same for any number of threads.
//! The factor is kept in f32, half the memory: its solution is a direction, which a line search or a second round
//! corrects.

use super::boughs::LANES;
use super::dissection::Symbolic;
use super::front_matrix::{AddElements, Bench, Unknowns, Updates, forward};
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::{Slices, take_first};
use crate::base::workers::{Serial, Workers, for_each_chunk};
use glam::DVec2;

/// Memory of a factored system.
pub struct Factor<'a> {
    values: &'a mut [f32],
}

/// One bough at work.
struct BoughJob<'j> {
    root: usize,
    y: &'j mut [f64],         // its unknowns, by position
    far: &'j [f64],           // the unknowns of its border
    columns: &'j mut [f32],   // nothing where they are not wanted
    update: &'j mut [f64],    // nothing on the way down
    part: &'j mut [f64],      // on the way down: memory of one front's unknowns
    bench: Option<Bench<'j>>, // where it is eliminated
    updates: Option<Updates<'j>>,
}

impl<'a> Factor<'a> {
    /// Memory for the factor of `symbolic`.
    pub fn new(symbolic: &Symbolic, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self { values: keep.take_unset(symbolic.plan.factor_len)? })
    }

    /// Solves A x = b, where `add(front, matrix)` adds the elements of each front to A and b; it is called twice for some.
    /// Returns b . x.
    pub fn solve(
        &mut self,
        x: &mut [DVec2],
        symbolic: &Symbolic,
        add: AddElements,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<f64, ScratchTooSmall> {
        let y = scratch.take::<f64>(2 * x.len())?; // by position
        self.up(y, symbolic, add, scratch.frame(), workers)?;
        // x = L^-T y, so b . x = |y|^2.
        let product = y.iter().map(|y| y * y).sum();
        self.down(y, symbolic, add, scratch, workers)?;
        for (position, node) in symbolic.order.iter().enumerate() {
            x[*node as usize] = DVec2::new(y[2 * position], y[2 * position + 1]);
        }
        Ok(product)
    }

    /// Solves for another right-hand side, `b`, with the factor of the last [`solve`](Self::solve), where all of it was kept; nothing
    /// where it was not. Returns b . x. Work is that of reading the factor twice.
    pub fn solve_again(
        &mut self,
        x: &mut [DVec2],
        b: &[DVec2],
        symbolic: &Symbolic,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<Option<f64>, ScratchTooSmall> {
        let plan = &symbolic.plan;
        if !plan.kept {
            return Ok(None);
        }
        let y = scratch.take::<f64>(2 * x.len())?; // by position
        for (pair, node) in y.as_chunks_mut::<2>().0.iter_mut().zip(symbolic.order) {
            *pair = b[*node as usize].to_array();
        }
        {
            let mut frame = scratch.frame();
            let part = frame.take::<f64>(plan.top.front.max(plan.bough.front))?;
            for front in symbolic.fronts {
                let columns = &self.values[front.factor as usize..][..front.column_len()];
                forward(y, front, columns, symbolic, part);
            }
        }
        let product = y.iter().map(|y| y * y).sum();
        self.down(y, symbolic, &|_, _| {}, scratch, workers)?;
        for (position, node) in symbolic.order.iter().enumerate() {
            x[*node as usize] = DVec2::new(y[2 * position], y[2 * position + 1]);
        }
        Ok(Some(product))
    }

    /// Eliminates everything from the leaves up; `y` becomes L^-1 b.
    fn up(
        &mut self,
        y: &mut [f64],
        symbolic: &Symbolic,
        add: AddElements,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<(), ScratchTooSmall> {
        let plan = &symbolic.plan;
        let mut updates = Updates::new(plan.top.stack, &mut scratch)?;
        let lanes = plan.lanes(symbolic.order.len(), scratch.remaining());
        let slots = scratch.take_unset::<f64>(lanes.min(plan.roots.len()) * plan.update_len)?;
        let (mut f, mut next, mut ready) = (0, 0, 0..0);
        while f < symbolic.fronts.len() {
            if next == ready.end && next < plan.roots.len() {
                ready = next..(next + lanes).min(plan.roots.len());
                self.raise(slots, y, ready.clone(), symbolic, add, scratch.frame(), workers)?;
            }
            while let Some(root) = ready.clone().find(|b| *b == next).map(|b| plan.roots[b] as usize) {
                let front = &symbolic.fronts[root];
                if front.leftmost as usize != f {
                    break;
                }
                let slot = &slots[(next - ready.start) * plan.update_len..][..front.update_len()];
                updates.push(root, front, |update| update.copy_from(slot));
                (f, next) = (root + 1, next + 1);
            }
            let end =
                plan.roots.get(next).map_or(symbolic.fronts.len(), |r| symbolic.fronts[*r as usize].leftmost as usize);
            if f == end {
                continue;
            }
            let mut frame = scratch.frame();
            let mut bench = Bench::new(plan.top.front, symbolic.order.len(), &mut frame)?;
            for f in f..end {
                let front = &symbolic.fronts[f];
                bench.eliminate(f, symbolic, &mut updates, add, workers);
                y[2 * front.first as usize..][..front.own()].copy_from(bench.solved());
                bench.write_columns(&mut self.values[front.factor as usize..][..front.column_len()]);
                updates.push(f, front, |update| bench.write_update(update));
            }
            f = end;
        }
        Ok(())
    }

    /// Eliminates some boughs side by side; their updates go to `slots`.
    #[allow(clippy::too_many_arguments)]
    fn raise(
        &mut self,
        slots: &mut [f64],
        y: &mut [f64],
        boughs: core::ops::Range<usize>,
        symbolic: &Symbolic,
        add: AddElements,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<(), ScratchTooSmall> {
        let plan = &symbolic.plan;
        let mut jobs = heapless::Vec::<BoughJob, LANES>::new();
        let (mut y, mut columns) = (Cursor::new(y), Cursor::new(&mut *self.values));
        let mut slots = Cursor::new(slots);
        for (slot, root) in plan.roots[boughs].iter().map(|r| *r as usize).enumerate() {
            let job = BoughJob {
                root,
                y: y.take(symbolic.positions_of(root), 2),
                far: &[],
                columns: if plan.kept { columns.take(symbolic.columns_of(root), 1) } else { &mut [] },
                update: slots.take(slot..slot + 1, plan.update_len),
                part: &mut [],
                bench: Some(Bench::new(plan.bough.front, symbolic.order.len(), &mut scratch)?),
                updates: Some(Updates::new(plan.bough.stack, &mut scratch)?),
            };
            jobs.put(job);
        }
        for_each_chunk(workers, &mut jobs, 1, &|_, job| {
            let job = &mut job[0];
            job.eliminate(true, symbolic, add);
            let len = symbolic.fronts[job.root].update_len();
            if let Some((_, update)) = job.updates.as_mut().and_then(|u| u.pop(symbolic)) {
                job.update[..len].copy_from(update);
            }
        });
        Ok(())
    }

    /// Solves L^T x = y from the root down.
    fn down(
        &mut self,
        y: &mut [f64],
        symbolic: &Symbolic,
        add: AddElements,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<(), ScratchTooSmall> {
        let plan = &symbolic.plan;
        let part = scratch.take::<f64>(plan.top.front)?;
        let mut after = symbolic.fronts.len();
        let mut all = Unknowns { first: 0, own: &mut *y, far_at: &[], far: &[] };
        for bough in (0..=plan.roots.len()).rev() {
            // The fronts between two boughs, and those after the last.
            let root = bough.checked_sub(1).map(|b| plan.roots[b] as usize);
            for front in symbolic.fronts[root.map_or(0, |r| r + 1)..after].iter().rev() {
                let columns = &self.values[front.factor as usize..][..front.column_len()];
                all.back(front, columns, symbolic, part);
            }
            after = root.map_or(0, |r| symbolic.fronts[r].leftmost as usize);
        }
        let lanes = plan.lanes(symbolic.order.len(), scratch.remaining());
        let mut done = 0;
        while done < plan.roots.len() {
            let boughs = done..(done + lanes).min(plan.roots.len());
            done = boughs.end;
            let mut frame = scratch.frame();
            let mut jobs = heapless::Vec::<BoughJob, LANES>::new();
            let mut far = heapless::Vec::<&[f64], LANES>::new();
            for root in &plan.roots[boughs.clone()] {
                let border = &symbolic.border[symbolic.fronts[*root as usize].border_range()];
                let values = frame.take::<f64>(2 * border.len())?;
                for (pair, p) in values.as_chunks_mut::<2>().0.iter_mut().zip(border) {
                    pair.copy_from(&y[2 * *p as usize..][..2]);
                }
                far.put(values);
            }
            let (mut y, mut columns) = (Cursor::new(&mut *y), Cursor::new(&mut *self.values));
            for (root, far) in plan.roots[boughs].iter().map(|r| *r as usize).zip(&far) {
                let mut job = BoughJob {
                    root,
                    y: y.take(symbolic.positions_of(root), 2),
                    far,
                    columns: &mut [],
                    update: &mut [],
                    part: frame.take_unset(plan.bough.front)?,
                    bench: None,
                    updates: None,
                };
                if plan.kept {
                    job.columns = columns.take(symbolic.columns_of(root), 1);
                } else {
                    job.columns = frame.take_unset(symbolic.columns_of(root).len())?;
                    job.bench = Some(Bench::new(plan.bough.front, symbolic.order.len(), &mut frame)?);
                    job.updates = Some(Updates::new(plan.bough.stack, &mut frame)?);
                }
                jobs.put(job);
            }
            for_each_chunk(workers, &mut jobs, 1, &|_, job| {
                job[0].eliminate(false, symbolic, add);
                job[0].back(symbolic);
            });
        }
        Ok(())
    }
}

impl BoughJob<'_> {
    /// Eliminates the bough's fronts, if it has the memory for that; `y` becomes L^-1 b where `solve` says so.
    fn eliminate(&mut self, solve: bool, symbolic: &Symbolic, add: AddElements) {
        let (Some(bench), Some(updates)) = (&mut self.bench, &mut self.updates) else { return };
        let leftmost = symbolic.fronts[self.root].leftmost as usize;
        let first = &symbolic.fronts[leftmost];
        for f in leftmost..=self.root {
            let front = &symbolic.fronts[f];
            bench.eliminate(f, symbolic, updates, add, &Serial);
            if solve {
                self.y[2 * (front.first - first.first) as usize..][..front.own()].copy_from(bench.solved());
            }
            if !self.columns.is_empty() {
                let at = (front.factor - first.factor) as usize;
                bench.write_columns(&mut self.columns[at..][..front.column_len()]);
            }
            updates.push(f, front, |update| bench.write_update(update));
        }
    }

    /// Solves L^T x = y for the bough's unknowns.
    fn back(&mut self, symbolic: &Symbolic) {
        let root = &symbolic.fronts[self.root];
        let leftmost = root.leftmost as usize;
        let first = &symbolic.fronts[leftmost];
        let mut unknowns = Unknowns {
            first: first.first as usize,
            own: &mut *self.y,
            far_at: &symbolic.border[root.border_range()],
            far: self.far,
        };
        for front in symbolic.fronts[leftmost..=self.root].iter().rev() {
            let at = (front.factor - first.factor) as usize;
            unknowns.back(front, &self.columns[at..][..front.column_len()], symbolic, self.part);
        }
    }
}

/// Cuts ascending, disjoint stretches out of a slice.
struct Cursor<'c, T> {
    rest: &'c mut [T],
    at: usize,
}

impl<'c, T> Cursor<'c, T> {
    fn new(slice: &'c mut [T]) -> Self {
        Self { rest: slice, at: 0 }
    }

    /// The values of `range`, counted in `size`.
    fn take(&mut self, range: core::ops::Range<usize>, size: usize) -> &'c mut [T] {
        let (first, last) = (range.start * size, range.end * size);
        let (head, skip) = (take_first(&mut self.rest, last - self.at), first - self.at);
        self.at = last;
        &mut head[skip..]
    }
}

#[cfg(test)]
mod tests {
    use super::super::front_matrix::FrontMatrix;
    use super::*;
    use crate::base::random::unit_f64;
    use crate::base::workers::tests::Backwards;
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
        for side in [1, 2, 5, 17, 40, 100, 150] {
            let (at, springs, start, neighbours) = grid(side);
            let n = at.len();
            let mut bytes = vec![0u8; 200_000_000];
            let mut scratch = Scratch::new(&mut bytes);
            let temporary = scratch.split(10_000_000).unwrap();
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
            let rhs: Vec<DVec2> =
                (0..n).map(|i| DVec2::new(unit_f64(2, 0, i as u64), unit_f64(2, 1, i as u64))).collect();
            let add = |f: u32, matrix: &mut FrontMatrix| {
                for (a, b, w) in &lists[f as usize] {
                    matrix.add(*a, *a, [*w, 0.0, 0.0, *w]);
                    matrix.add(*b, *b, [*w, 0.0, 0.0, *w]);
                    matrix.add(*a, *b, [-*w, 0.1, 0.0, -*w]);
                }
                for i in &diagonal[f as usize] {
                    matrix.add(*i, *i, [0.5, 0.1, 0.1, 0.5]);
                    matrix.add_vector(*i, rhs[*i as usize]);
                }
            };
            let mut x = vec![DVec2::ZERO; n];
            let fall = factor.solve(&mut x, &symbolic, &add, scratch.frame(), &Serial).unwrap();
            // Boughs in any order, on other threads: the same bits.
            let mut again = vec![DVec2::ZERO; n];
            factor.solve(&mut again, &symbolic, &add, scratch.frame(), &Backwards).unwrap();
            assert!(
                x.iter().zip(&again).all(|(a, b)| a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits))
            );
            // The kept factor: the same solution, but for the single precision of what is eliminated again.
            let mut kept = vec![DVec2::ZERO; n];
            let same = factor.solve_again(&mut kept, &rhs, &symbolic, scratch.frame(), &Serial).unwrap();
            assert!(same.is_some_and(|same| (same - fall).abs() < 1e-5 * fall), "{side}: {same:?} {fall}");
            assert!(x.iter().zip(&kept).all(|(a, b)| a.distance(*b) < 2e-5));
            let exact: f64 = x.iter().zip(&rhs).map(|(x, b)| x.dot(*b)).sum();
            assert!((fall - exact).abs() < 1e-5 * exact, "{side}: {fall} {exact}");
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
        assert_eq!(factor.solve(&mut [], &symbolic, &|_, _| {}, scratch.frame(), &Serial), Ok(0.0));
    }
}
