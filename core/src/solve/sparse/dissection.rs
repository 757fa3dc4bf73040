//! Order of elimination by nested dissection (George 1973): fronts, their tree and their borders.
//!
//! Ranges are halved by coordinates; where that separator is wide (charts in layers), one is looked for along the graph.
//! Depends on the graph alone, so it is found once for many factorisations. O(n log n).

use super::boughs::{BoughPlan, plan};
use super::front::Front;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::sort;
use glam::DVec3;

/// Ranges of at most this many nodes are eliminated as one front. 8: 12 % slower (fronts too small), 48: 9 % slower
/// (work on zeros), on a 3,000-node chart.
const LEAF: usize = 20;
/// A separator of more than sqrt(WIDE n) nodes is looked for anew along the graph. Charts as they occur have 1 to 2.
const WIDE: usize = 6;

/// Elimination order, fronts and their borders: what depends on the graph alone.
pub struct Symbolic<'a> {
    pub(super) order: &'a [u32],    // (n) node at each position
    place: &'a [u32],               // (n) position of each node
    front_of: &'a [u32],            // (n) front that eliminates each position
    pub(super) fronts: &'a [Front], // in elimination order, children before parents
    pub(super) border: &'a [u32],   // positions
    pub(super) plan: BoughPlan<'a>,
}

/// A range of the order that still has to be split, or a separator whose sides are done.
#[derive(Clone, Copy)]
enum DissectionTask {
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
        let plan = plan(fronts, keep)?;
        Ok(Self { order, place, front_of, fronts, border, plan })
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

    /// Positions that the subtree of front `root` eliminates.
    pub(super) fn positions_of(&self, root: usize) -> core::ops::Range<usize> {
        let (first, last) = (&self.fronts[self.fronts[root].leftmost as usize], &self.fronts[root]);
        first.first as usize..(last.first + last.count) as usize
    }

    /// Places of the columns of that subtree in the factor, or in their own memory.
    pub(super) fn columns_of(&self, root: usize) -> core::ops::Range<usize> {
        let (first, last) = (&self.fronts[self.fronts[root].leftmost as usize], &self.fronts[root]);
        first.factor as usize..last.factor as usize + last.column_len()
    }

    /// Number of fronts.
    pub fn front_count(&self) -> usize {
        self.fronts.len()
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
    let graph = Neighbours { start, list: neighbours, at };
    let mut stamp = 2;
    let mut count = 0;
    let mut tasks = heapless::Vec::<DissectionTask, 256>::new();
    tasks.put(DissectionTask::Split { first: 0, last: n });
    while let Some(task) = tasks.pop() {
        match task {
            DissectionTask::Emit { first, last, children } => {
                fronts[count] =
                    Front { first: first as u32, count: (last - first) as u32, children, ..Front::default() };
                count += 1;
            }
            DissectionTask::Split { first, last } if first == last => {}
            DissectionTask::Split { first, last } => {
                // Each level uses two entries more; a median split halves the range, so depth is at most log2(n) + 1.
                let small = last - first <= LEAF || tasks.capacity() - tasks.len() < 3;
                if small {
                    tasks.put(DissectionTask::Emit { first, last, children: 0 });
                    continue;
                }
                let (a_len, b_len) = part(&mut order[first..last], spare, side, &mut stamp, &graph);
                let (m, e) = (first + a_len, first + a_len + b_len);
                let children = u32::from(a_len > 0) + u32::from(b_len > 0);
                tasks.put(DissectionTask::Emit { first: e, last, children });
                tasks.put(DissectionTask::Split { first: m, last: e });
                tasks.put(DissectionTask::Split { first, last: m });
            }
        }
    }
    Ok(count)
}

/// The graph, and where its nodes stand.
struct Neighbours<'g> {
    start: &'g [u32], // (n + 1)
    list: &'g [u32],
    at: &'g [DVec3], // (n)
}

impl Neighbours<'_> {
    /// Whether a neighbour of node `i` has the mark `other`.
    fn touches(&self, i: u32, side: &[u32], other: u32) -> bool {
        let i = i as usize;
        self.list[self.start[i] as usize..self.start[i + 1] as usize].iter().any(|j| side[*j as usize] == other)
    }
}

/// Sorts a range of nodes into those on one side of a separator, those on the other, and the separator; returns how many the two
/// sides have. Uses marks from `stamp` on, which goes on.
fn part(range: &mut [u32], spare: &mut [u32], side: &mut [u32], stamp: &mut u32, graph: &Neighbours) -> (usize, usize) {
    let middle = range.len() / 2;
    halve_by_place(range, graph.at);
    *stamp += 2;
    let mut touching = mark(range, side, *stamp, graph);
    if touching * touching > WIDE * range.len() && range.len() > 4 * LEAF {
        // Layers over each other in space: follow the graph instead, if that is better.
        *stamp += 4;
        order_by_breadth(range, spare, side, *stamp - 2, graph);
        let by_breadth = mark(range, side, *stamp, graph);
        if by_breadth >= touching {
            halve_by_place(range, graph.at);
            mark(range, side, *stamp, graph);
        } else {
            touching = by_breadth;
        }
    }
    let stamp = *stamp;
    let a_touch = range[..middle].iter().filter(|i| graph.touches(**i, side, stamp + 1)).count();
    let b_touch = range[middle..].iter().filter(|i| graph.touches(**i, side, stamp)).count();
    // The separator: the side's nodes that touch the other one, from the side that has fewer.
    let (own, other) = if a_touch <= b_touch { (stamp, stamp + 1) } else { (stamp + 1, stamp) };
    let spare = &mut spare[..range.len()];
    let (mut a, mut b, mut s) = (0, 0, 0);
    let separator = touching;
    let a_len = middle - if own == stamp { separator } else { 0 };
    let b_len = range.len() - separator - a_len;
    for i in range.iter() {
        let mine = side[*i as usize];
        if mine == own && graph.touches(*i, side, other) {
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
    range.copy_from(spare);
    (a_len, b_len)
}

/// Puts the half of the nodes that lies lower along the longest axis first.
fn halve_by_place(range: &mut [u32], at: &[DVec3]) {
    let (low, high) = range
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), i| (l.min(at[*i as usize]), h.max(at[*i as usize])));
    let axis = (high - low).max_position();
    let along = |i: &u32| at[*i as usize].to_array()[axis];
    let middle = range.len() / 2;
    sort::select_by(range, middle, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
}

/// Marks the first half of the nodes with `stamp`, the others with `stamp + 1`; returns the size of the smaller side's
/// row of nodes that touch the other side.
fn mark(range: &[u32], side: &mut [u32], stamp: u32, graph: &Neighbours) -> usize {
    let middle = range.len() / 2;
    let (a, b) = (&range[..middle], &range[middle..]);
    a.iter().for_each(|i| side[*i as usize] = stamp);
    b.iter().for_each(|i| side[*i as usize] = stamp + 1);
    let side = &*side;
    let touching = |half: &[u32], other: u32| half.iter().filter(|i| graph.touches(**i, side, other)).count();
    touching(a, stamp + 1).min(touching(b, stamp))
}

/// Orders the nodes by breadth-first search from one end of their graph. Uses the marks `stamp` and `stamp + 1`.
fn order_by_breadth(range: &mut [u32], queue: &mut [u32], side: &mut [u32], stamp: u32, graph: &Neighbours) {
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
                for j in &graph.list[graph.start[i] as usize..graph.start[i + 1] as usize] {
                    if side[*j as usize] == unseen {
                        side[*j as usize] = seen;
                        queue[tail] = *j;
                        tail += 1;
                    }
                }
            }
        }
        range.copy_from(&queue[..tail]);
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
            debug_assert!(open.len() >= front.children as usize, "children stand before their parent");
            for _ in 0..front.children {
                if let Some(child) = open.pop() {
                    let child = fronts[child as usize];
                    let range = (child.border as usize, (child.border + child.border_len) as usize);
                    children.put(range);
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
            sort::ascending(&mut out[begin..len]);
            fronts[f].border = begin as u32;
            fronts[f].border_len = (len - begin) as u32;
            open.put(f as u32);
        }
        Some(len)
    };
    Ok(&*keep.fill(fill)?)
}
