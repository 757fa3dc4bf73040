//! Boughs: subtrees of the dissection's tree that are eliminated as one task each.
//!
//! Boughs share nothing but what they hand to the fronts above them, so workers take them side by side. Of a large system
//! their columns are not kept: most of all memory, but the lesser part of the work, which is done again when the solution comes
//! down. The stack of updates counts as Liu 1986 does it (*On the storage requirement in the out-of-core multifrontal method
//! for sparse factorization*, ACM TOMS 12).
//! Which fronts are in boughs depends on the tree alone, never on the number of threads.

use super::front::Front;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};

/// Nodes of a bough at the most. With 4000 the command takes 187 MB for a mesh of 100,000 faces, with 1000 168 MB.
pub(super) const BOUGH: usize = 1000;
/// A system of up to so many nodes is parted in two halves: what is above them is a third of all work, above quarters it is half.
const HALVED: usize = 2000;
/// Smaller ones are one bough: they are done before another could begin.
const WHOLE: usize = 300;
/// So are those with a larger front, which comes of nodes of many neighbours: it takes its memory once.
const WIDE: usize = 512;
/// The columns of boughs are kept in systems of up to so many nodes.
pub(super) const KEPT: usize = 60_000;
/// Boughs that are eliminated at the same time at the most.
pub(super) const LANES: usize = 16;

/// What a factorisation needs to know beside the fronts.
#[derive(Clone, Copy)]
pub(super) struct BoughPlan<'a> {
    /// Root of each bough, ascending.
    pub roots: &'a [u32],
    /// Whether the columns of boughs are kept.
    pub kept: bool,
    /// Values of the factor.
    pub factor_len: usize,
    /// Largest demands of the boughs and of the fronts above them.
    pub bough: Demand,
    pub top: Demand,
    /// Values of the largest update that a bough leaves.
    pub update_len: usize,
}

impl BoughPlan<'_> {
    /// Boughs of a system of `nodes` that can be eliminated at the same time in `free` bytes, at least one: this changes no result.
    pub fn lanes(&self, nodes: usize, free: usize) -> usize {
        let Demand { front, stack, columns } = self.bough;
        // The matrix, its right-hand side, unknowns and border; waiting updates; the last update.
        let doubles = front * (front + 3) + stack + self.update_len;
        let columns = if self.kept { 0 } else { columns };
        let one =
            bytes_for::<f64>(doubles) + bytes_for::<u32>(nodes) + bytes_for::<f32>(columns) + 8 * bytes_for::<u8>(0);
        free.checked_div(one).map_or(1, |lanes| lanes.clamp(1, LANES))
    }
}

/// Memory of an elimination.
#[derive(Clone, Copy, Default)]
pub(super) struct Demand {
    /// Largest front's side.
    pub front: usize,
    /// Values of the stack of waiting updates at its fullest.
    pub stack: usize,
    /// Values of all columns.
    pub columns: usize,
}

impl Demand {
    fn cover(&mut self, other: Demand) {
        self.front = self.front.max(other.front);
        self.stack = self.stack.max(other.stack);
        self.columns = self.columns.max(other.columns);
    }
}

/// Finds the boughs, completes the fronts (`leftmost`, `factor`), and counts memory.
pub(super) fn plan<'a>(fronts: &mut [Front], keep: &mut Scratch<'a>) -> Result<BoughPlan<'a>, ScratchTooSmall> {
    let mut open = heapless::Vec::<u32, 128>::new(); // fronts without a parent yet
    for f in 0..fronts.len() {
        let mut leftmost = f as u32;
        debug_assert!(open.len() >= fronts[f].children as usize, "children stand before their parent");
        for _ in 0..fronts[f].children {
            leftmost = open.pop().map_or(leftmost, |child| fronts[child as usize].leftmost);
        }
        fronts[f].leftmost = leftmost;
        open.put(f as u32);
    }
    let nodes = |f: usize| {
        let (first, last) = (&fronts[fronts[f].leftmost as usize], &fronts[f]);
        (last.first + last.count - first.first) as usize
    };
    let all = fronts.last().map_or(0, |f| (f.first + f.count) as usize);
    let is_whole = all <= WHOLE || all <= HALVED && fronts.iter().any(|f| f.size() > WIDE);
    let most = if is_whole {
        all
    } else if all <= HALVED {
        all * 5 / 8
    } else {
        BOUGH
    };
    let kept = all <= KEPT;
    // From the last front down: a bough is stepped over whole.
    let walk = |visit: &mut dyn FnMut(usize)| {
        let mut f = fronts.len();
        while f > 0 {
            let root = f - 1;
            f = if nodes(root) <= most {
                visit(root);
                fronts[root].leftmost as usize
            } else {
                root
            };
        }
    };
    let mut count = 0;
    walk(&mut |_| count += 1);
    let roots = keep.take::<u32>(count)?;
    walk(&mut |root| {
        count -= 1;
        roots[count] = root as u32;
    });
    let mut plan = BoughPlan {
        roots,
        kept,
        factor_len: 0,
        bough: Demand::default(),
        top: Demand::default(),
        update_len: roots.iter().map(|r| fronts[*r as usize].update_len()).max().unwrap_or(0),
    };
    let (mut f, mut next) = (0, 0);
    let mut above = UpdateStack::default();
    while f < fronts.len() {
        if let Some(root) = roots.get(next).map(|r| *r as usize).filter(|r| fronts[*r].leftmost as usize == f) {
            let mut inside = UpdateStack::default();
            let mut demand = Demand::default();
            for front in &mut fronts[f..=root] {
                front.factor = (if kept { plan.factor_len } else { 0 } + demand.columns) as u64;
                demand.columns += front.column_len();
                demand.front = demand.front.max(front.size());
                inside.step(front.children, front.update_len());
            }
            demand.stack = inside.most;
            plan.bough.cover(demand);
            plan.factor_len += if kept { demand.columns } else { 0 };
            above.step(0, fronts[root].update_len());
            (f, next) = (root + 1, next + 1);
        } else {
            let front = &mut fronts[f];
            front.factor = plan.factor_len as u64;
            plan.factor_len += front.column_len();
            plan.top.front = plan.top.front.max(front.size());
            above.step(front.children, front.update_len());
            f += 1;
        }
    }
    plan.top.stack = above.most;
    Ok(plan)
}

/// Sizes on a stack of updates: those of finished fronts whose parent is still to come.
#[derive(Default)]
struct UpdateStack {
    waiting: heapless::Vec<usize, 128>,
    now: usize,
    most: usize,
}

impl UpdateStack {
    fn step(&mut self, children: u32, update: usize) {
        debug_assert!(self.waiting.len() >= children as usize, "children are finished before their parent");
        for _ in 0..children {
            self.now -= self.waiting.pop().unwrap_or(0);
        }
        self.now += update;
        self.most = self.most.max(self.now);
        self.waiting.put(update);
    }
}
