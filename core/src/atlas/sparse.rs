//! Direct solver for the sparse positive definite systems of planar meshes: two unknowns a node.
//!
//! Nested dissection (George 1973) by coordinate bisection gives the order; the multifrontal method (Duff, Reid 1983;
//! Liu 1992) factors dense fronts along its tree. No global matrix is stored: a caller adds each element's matrix to the
//! front in which its first node is eliminated.
//! Cost for n nodes of a planar graph: O(n log n) memory, O(n^1.5) operations. Every sum has a fixed order.
//! The factor is kept in f32, half the memory: its solution is a direction, which a line search or a second round
//! corrects. Limit: a pivot that is not positive is replaced by a huge one, which holds that unknown where it is.

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::vector::wide;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// Ranges of at most this many nodes are eliminated as one front. 8: 12 % slower (fronts too small), 48: 9 % slower
/// (work on zeros), on a 3,000-node chart.
const LEAF: usize = 20;
/// A separator of more than sqrt(WIDE n) nodes is looked for anew along the graph. Charts as they occur have 1 to 2.
const WIDE: usize = 6;
/// Columns of a dense panel. 4: 20 % slower; 16: the same.
const PANEL: usize = 8;

/// One front: `count` nodes are eliminated, `border_len` later nodes are updated.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Front {
    factor: u64, // first value of its columns in the factor
    first: u32,  // first position in elimination order
    count: u32,
    border: u32, // first entry in the list of border positions
    border_len: u32,
    children: u32,
    unused: u32,
}

impl Front {
    fn size(&self) -> usize {
        2 * (self.count + self.border_len) as usize
    }
}

/// Elimination order, fronts and their borders: what depends on the graph alone.
pub struct Symbolic<'a> {
    order: &'a [u32],    // (n) node at each position
    place: &'a [u32],    // (n) position of each node
    front_of: &'a [u32], // (n) front that eliminates each position
    fronts: &'a [Front], // in elimination order, children before parents
    border: &'a [u32],   // positions
    factor_len: usize,   // values of the factor
    front_size: usize,   // largest front's side
    stack_len: usize,    // values of the stack of waiting updates at its fullest
}

/// A range of the order that still has to be split, or a separator whose sides are done.
#[derive(Clone, Copy)]
enum Task {
    Split { first: usize, last: usize },
    Emit { first: usize, last: usize, children: u32 },
}

impl<'a> Symbolic<'a> {
    /// Orders the graph whose node i has the neighbours `neighbours[start[i]..start[i + 1]]` (repeats are harmless) and
    /// stands at `at[i]`.
    pub fn new(
        start: &[u32],
        neighbours: &[u32],
        at: &[DVec3],
        keep: &mut Scratch<'a>,
        mut scratch: Scratch,
    ) -> Result<Self, ScratchTooSmall> {
        let n = at.len();
        let order = keep.take::<u32>(n)?;
        let place = keep.take::<u32>(n)?;
        let front_of = keep.take::<u32>(n)?;
        order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
        let fronts_max = 2 * (n / (LEAF / 4).max(1)) + 64;
        let fronts = keep.take::<Front>(fronts_max)?;
        let count = dissect(order, fronts, start, neighbours, at, scratch.frame())?;
        let fronts = &mut fronts[..count];
        for (position, node) in order.iter().enumerate() {
            place[*node as usize] = position as u32;
        }
        for (i, front) in fronts.iter().enumerate() {
            front_of[front.first as usize..(front.first + front.count) as usize].fill(i as u32);
        }
        let border = borders(fronts, order, place, start, neighbours, keep, scratch)?;
        let (mut factor_len, mut front_size, mut stack, mut stack_len) = (0, 0, 0usize, 0usize);
        // The stack holds the updates of finished fronts whose parent is still to come.
        let mut waiting = heapless::Vec::<usize, 128>::new();
        for front in fronts.iter_mut() {
            front.factor = factor_len as u64;
            factor_len += 2 * front.count as usize * front.size();
            front_size = front_size.max(front.size());
            for _ in 0..front.children {
                stack -= waiting.pop().unwrap_or(0);
            }
            let update = 4 * (front.border_len as usize) * (front.border_len as usize);
            stack += update;
            stack_len = stack_len.max(stack);
            waiting.push(update).ok();
        }
        Ok(Self { order, place, front_of, fronts, border, factor_len, front_size, stack_len })
    }

    /// The front to which an element over these nodes belongs; nodes of `NONE` are fixed and not part of the system.
    pub fn front_of_element(&self, nodes: impl Iterator<Item = u32>) -> Option<u32> {
        nodes.map(|node| self.place[node as usize]).min().map(|p| self.front_of[p as usize])
    }

    /// Nodes that front `f` eliminates.
    pub fn own_nodes(&self, f: usize) -> &[u32] {
        let front = &self.fronts[f];
        &self.order[front.first as usize..(front.first + front.count) as usize]
    }

    /// Number of fronts.
    pub fn front_count(&self) -> usize {
        self.fronts.len()
    }

    /// Values in the factor.
    pub fn factor_len(&self) -> usize {
        self.factor_len
    }
}

/// Reorders `order` by nested dissection and lists the fronts.
fn dissect(
    order: &mut [u32],
    fronts: &mut [Front],
    start: &[u32],
    neighbours: &[u32],
    at: &[DVec3],
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let n = order.len();
    let side = scratch.take::<u32>(n)?;
    let spare = scratch.take::<u32>(n)?;
    let mut stamp = 2;
    let mut count = 0;
    let mut tasks = heapless::Vec::<Task, 256>::new();
    tasks.push(Task::Split { first: 0, last: n }).ok();
    while let Some(task) = tasks.pop() {
        match task {
            Task::Emit { first, last, children } => {
                fronts[count] =
                    Front { first: first as u32, count: (last - first) as u32, children, ..Front::default() };
                count += 1;
            }
            Task::Split { first, last } if first == last => {}
            Task::Split { first, last } => {
                // Each level uses two entries more; a median split halves the range, so depth is at most log2(n) + 1.
                let small = last - first <= LEAF || tasks.capacity() - tasks.len() < 3;
                if small {
                    tasks.push(Task::Emit { first, last, children: 0 }).ok();
                    continue;
                }
                let range = &mut order[first..last];
                let middle = range.len() / 2;
                halve_by_place(range, at);
                stamp += 2;
                let mut touching = mark(range, side, stamp, start, neighbours);
                if touching * touching > WIDE * range.len() && range.len() > 4 * LEAF {
                    // Layers over each other in space: follow the graph instead, if that is better.
                    stamp += 4;
                    order_by_breadth(range, spare, side, stamp - 2, start, neighbours);
                    let by_breadth = mark(range, side, stamp, start, neighbours);
                    if by_breadth >= touching {
                        halve_by_place(range, at);
                        mark(range, side, stamp, start, neighbours);
                    } else {
                        touching = by_breadth;
                    }
                }
                let touches = |i: u32, other: u32| {
                    neighbours[start[i as usize] as usize..start[i as usize + 1] as usize]
                        .iter()
                        .any(|j| side[*j as usize] == other)
                };
                let a_touch = range[..middle].iter().filter(|i| touches(**i, stamp + 1)).count();
                let b_touch = range[middle..].iter().filter(|i| touches(**i, stamp)).count();
                // The separator: the side's nodes that touch the other one, from the side that has fewer.
                let (own, other) = if a_touch <= b_touch { (stamp, stamp + 1) } else { (stamp + 1, stamp) };
                let spare = &mut spare[..range.len()];
                let (mut a, mut b, mut s) = (0, 0, 0);
                let separator = touching;
                let a_len = middle - if own == stamp { separator } else { 0 };
                let b_len = range.len() - separator - a_len;
                for i in range.iter() {
                    let mine = side[*i as usize];
                    if mine == own && touches(*i, other) {
                        spare[a_len + b_len + s] = *i;
                        s += 1;
                    } else if mine == stamp {
                        spare[a] = *i;
                        a += 1;
                    } else {
                        spare[a_len + b] = *i;
                        b += 1;
                    }
                }
                range.copy_from_slice(spare);
                let (m, e) = (first + a_len, first + a_len + b_len);
                let children = u32::from(a_len > 0) + u32::from(b_len > 0);
                tasks.push(Task::Emit { first: e, last, children }).ok();
                tasks.push(Task::Split { first: m, last: e }).ok();
                tasks.push(Task::Split { first, last: m }).ok();
            }
        }
    }
    Ok(count)
}

/// Puts the half of the nodes that lies lower along the longest axis first.
fn halve_by_place(range: &mut [u32], at: &[DVec3]) {
    let (low, high) = range
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), i| (l.min(at[*i as usize]), h.max(at[*i as usize])));
    let axis = (high - low).max_position();
    range.select_nth_unstable_by(range.len() / 2, |a, b| {
        at[*a as usize][axis].total_cmp(&at[*b as usize][axis]).then(a.cmp(b))
    });
}

/// Marks the first half of the nodes with `stamp`, the others with `stamp + 1`; returns the size of the smaller side's
/// row of nodes that touch the other side.
fn mark(range: &[u32], side: &mut [u32], stamp: u32, start: &[u32], neighbours: &[u32]) -> usize {
    let (a, b) = range.split_at(range.len() / 2);
    a.iter().for_each(|i| side[*i as usize] = stamp);
    b.iter().for_each(|i| side[*i as usize] = stamp + 1);
    let touching = |half: &[u32], other: u32| {
        let touches = |i: &&u32| {
            let i = **i as usize;
            neighbours[start[i] as usize..start[i + 1] as usize].iter().any(|j| side[*j as usize] == other)
        };
        half.iter().filter(touches).count()
    };
    touching(a, stamp + 1).min(touching(b, stamp))
}

/// Orders the nodes by breadth-first search from one end of their graph. Uses the marks `stamp` and `stamp + 1`.
fn order_by_breadth(
    range: &mut [u32],
    queue: &mut [u32],
    side: &mut [u32],
    stamp: u32,
    start: &[u32],
    neighbours: &[u32],
) {
    range.iter().for_each(|i| side[*i as usize] = stamp - 1);
    for pass in 0..2 {
        let (unseen, seen) = (stamp - 1 + pass, stamp + pass);
        let (mut head, mut tail) = (0, 0);
        // The second search starts where the first one ended.
        for k in 0..range.len() {
            let seed = range[if pass == 0 { k } else { range.len() - 1 - k }];
            if side[seed as usize] != unseen {
                continue;
            }
            side[seed as usize] = seen;
            queue[tail] = seed;
            tail += 1;
            while head < tail {
                let i = queue[head] as usize;
                head += 1;
                for j in &neighbours[start[i] as usize..start[i + 1] as usize] {
                    if side[*j as usize] == unseen {
                        side[*j as usize] = seen;
                        queue[tail] = *j;
                        tail += 1;
                    }
                }
            }
        }
        range.copy_from_slice(&queue[..tail]);
    }
}

/// Lists each front's border: the later positions that its nodes or its children's borders touch, ascending.
fn borders<'a>(
    fronts: &mut [Front],
    order: &[u32],
    place: &[u32],
    start: &[u32],
    neighbours: &[u32],
    keep: &mut Scratch<'a>,
    mut scratch: Scratch,
) -> Result<&'a [u32], ScratchTooSmall> {
    let seen = scratch.take::<u32>(order.len())?;
    let mut open = heapless::Vec::<u32, 128>::new(); // fronts without a parent yet
    let fill = |out: &mut [u32]| {
        let mut len = 0;
        for f in 0..fronts.len() {
            let front = fronts[f];
            let (first, end) = (front.first, front.first + front.count);
            let begin = len;
            let mut add = |p: u32, len: &mut usize| -> Option<()> {
                if p >= end && seen[p as usize] != f as u32 + 1 {
                    seen[p as usize] = f as u32 + 1;
                    *out.get_mut(*len)? = p;
                    *len += 1;
                }
                Some(())
            };
            for position in first..end {
                let node = order[position as usize] as usize;
                for j in &neighbours[start[node] as usize..start[node + 1] as usize] {
                    add(place[*j as usize], &mut len)?;
                }
            }
            let mut children = heapless::Vec::<(usize, usize), 4>::new();
            for _ in 0..front.children {
                if let Some(child) = open.pop() {
                    let child = fronts[child as usize];
                    let range = (child.border as usize, (child.border + child.border_len) as usize);
                    children.push(range).ok();
                }
            }
            for (from, to) in children {
                for at in from..to {
                    let p = out[at];
                    if p >= end && seen[p as usize] != f as u32 + 1 {
                        seen[p as usize] = f as u32 + 1;
                        *out.get_mut(len)? = p;
                        len += 1;
                    }
                }
            }
            out[begin..len].sort_unstable();
            fronts[f].border = begin as u32;
            fronts[f].border_len = (len - begin) as u32;
            open.push(f as u32).ok();
        }
        Some(len)
    };
    Ok(&*keep.fill(fill)?)
}

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

/// Eliminates the first `own` columns of the dense lower triangle `a` (m x m, by columns).
#[inline(always)]
fn partial_cholesky(a: &mut [f64], m: usize, own: usize) {
    let mut p = 0;
    while p < own {
        let width = PANEL.min(own - p);
        for j in p..p + width {
            let (head, tail) = a.split_at_mut((j + 1) * m);
            let column = &mut head[j * m..];
            let pivot = if column[j] > 0.0 { sqrt(column[j]) } else { 1e30 };
            column[j] = pivot;
            let inverse = 1.0 / pivot;
            column[j + 1..m].iter_mut().for_each(|x| *x *= inverse);
            for k in j + 1..p + width {
                let other = &mut tail[(k - j - 1) * m..(k - j) * m];
                let f = column[k];
                for (x, l) in other[k..].iter_mut().zip(&column[k..m]) {
                    *x -= f * l;
                }
            }
        }
        let (head, tail) = a.split_at_mut((p + width) * m);
        let panel = &head[p * m..];
        for k in p + width..m {
            let column = &mut tail[(k - p - width) * m + k..(k - p - width + 1) * m];
            if width == PANEL {
                subtract_panel(column, panel, m, k);
            } else {
                for j in 0..width {
                    let l = &panel[j * m + k..(j + 1) * m];
                    let f = l[0];
                    for (x, l) in column.iter_mut().zip(l) {
                        *x -= f * l;
                    }
                }
            }
        }
        p += width;
    }
}

/// column -= sum over the panel's columns of its entry at row k times its rows from k on.
#[inline(always)]
fn subtract_panel(column: &mut [f64], panel: &[f64], m: usize, k: usize) {
    let n = column.len();
    let l: [&[f64]; PANEL] = core::array::from_fn(|j| &panel[j * m + k..j * m + k + n]);
    let f: [f64; PANEL] = core::array::from_fn(|j| l[j][0]);
    for i in 0..n {
        let a = (f[0] * l[0][i] + f[1] * l[1][i]) + (f[2] * l[2][i] + f[3] * l[3][i]);
        let b = (f[4] * l[4][i] + f[5] * l[5][i]) + (f[6] * l[6][i] + f[7] * l[7][i]);
        column[i] -= a + b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
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
