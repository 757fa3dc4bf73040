//! Border edges that lie along one another: for each the one whose ends are nearest to its own.
//!
//! The middles of two such edges are as near as their ends, and their lengths as alike, so middles are sorted by cells of a grid, a grid
//! for each octave of lengths: O(n log n) for n edges, since what an edge is compared to lies within its own length of it.

use super::joints::Joints;
use super::open_side::OpenSide;
use super::view::NONE;
use crate::base::real::{floor, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use glam::DVec3;

/// Edges that are looked at in a row of cells: more of one length in one place are a heap of sheets, not a crack.
const MOST_IN_A_ROW: usize = 256;

/// Cell of a middle: octave of the length, then the cell of the grid.
type Cell = [i64; 4];

/// The partners of border edges.
pub(super) struct Partners<'a> {
    widest: f64,
    middle: &'a mut [DVec3], // (e)
    length: &'a mut [f64],   // (e)
    order: &'a mut [u32],    // (e), by cell
    partner: &'a mut [u32],  // (e); of an edge that is done, itself
    refused: &'a mut [u32],  // (e), the last partner that did not do
    width: &'a mut [f64],    // (e)
    pairs: &'a mut [u32],    // (e)
}

/// Scratch bytes for [`Partners::new`].
pub(super) const fn partners_need(edges: usize) -> usize {
    bytes_for::<DVec3>(edges)
        .saturating_add(bytes_for::<f64>(edges).saturating_mul(2))
        .saturating_add(bytes_for::<u32>(edges).saturating_mul(4))
}

impl<'a> Partners<'a> {
    /// For cracks of at most `widest`.
    pub fn new(
        edges: &[OpenSide],
        place: impl Fn(u32) -> DVec3,
        widest: f64,
        scratch: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let n = edges.len();
        let mut partners = Self {
            widest,
            middle: scratch.take(n)?,
            length: scratch.take(n)?,
            order: scratch.take(n)?,
            partner: scratch.take_filled(n, NONE)?,
            refused: scratch.take_filled(n, NONE)?,
            width: scratch.take(n)?,
            pairs: scratch.take(n)?,
        };
        for (e, &[a, b, _]) in edges.iter().enumerate() {
            let (a, b) = (place(a), place(b));
            partners.middle[e] = (a + b) * 0.5;
            partners.length[e] = sqrt((b - a).dot(b - a));
        }
        partners.sort();
        Ok(partners)
    }

    /// From now on for cracks of at most `widest`, which is less than before.
    pub fn narrow(&mut self, widest: f64) {
        self.widest = widest;
        self.sort();
    }

    fn sort(&mut self) {
        self.order.iter_mut().enumerate().for_each(|(i, e)| *e = i as u32);
        let Self { widest, middle, length, .. } = self;
        let cell = |e: u32| cell(octave(length[e as usize]), middle[e as usize], *widest);
        sort::by(self.order, |&a, &b| cell(a).cmp(&cell(b)).then(a.cmp(&b)));
    }

    /// Finds the partner of each edge that is not done, no further than `of_length` of the shorter of the two.
    pub fn find(&mut self, edges: &[OpenSide], place: impl Fn(u32) -> DVec3, joints: &Joints, of_length: f64) {
        for e in 0..edges.len() {
            if self.partner[e] == e as u32 {
                continue;
            }
            let reach = self.widest.min(of_length * self.length[e]);
            let mut best = (f64::INFINITY, NONE);
            self.near(e, reach, |f| {
                let width = joints.width(edges[e], edges[f as usize], &place);
                let most = reach.min(of_length * self.length[f as usize]);
                let is_free =
                    self.partner[f as usize] != f && self.refused[e] != f && self.refused[f as usize] != e as u32;
                // Of equally near ones that whose pair has the lower numbers, so that both sides agree.
                let [new, old] = [f, best.1].map(|f| (f.min(e as u32), f.max(e as u32)));
                if is_free && width <= most && (width < best.0 || width == best.0 && new < old) {
                    best = (width, f);
                }
            });
            // Written after all have looked: nobody reads partners that are not done.
            (self.width[e], self.pairs[e]) = best;
        }
        for e in 0..edges.len() {
            if self.partner[e] != e as u32 {
                self.partner[e] = self.pairs[e];
            }
        }
    }

    /// Edges that may lie along `e` within `reach`.
    fn near(&self, e: usize, reach: f64, mut see: impl FnMut(u32)) {
        let [low, high] = [-1.0, 1.0].map(|sign| (self.length[e] + 2.0 * sign * reach).max(0.5 * self.length[e]));
        let at = |i: u32| cell(octave(self.length[i as usize]), self.middle[i as usize], self.widest);
        for octave in octave(low)..=octave(high) {
            let [first, last] = [-reach, reach].map(|r| cell(octave, self.middle[e] + r, self.widest));
            for x in first[1]..=last[1] {
                for y in first[2]..=last[2] {
                    let [from, to] = [[octave, x, y, first[3]], [octave, x, y, last[3]]];
                    let start = self.order.partition_point(|i| at(*i) < from);
                    let row = self.order.iter().skip(start).take(MOST_IN_A_ROW).take_while(|i| at(**i) <= to);
                    row.filter(|i| **i as usize != e).for_each(|i| see(*i));
                }
            }
        }
    }

    /// Edges that are one another's partners, the lower first, with the width between them.
    pub fn pairs(&self) -> impl Iterator<Item = (u32, f64)> {
        let lower = |e: &u32| {
            let partner = self.partner[*e as usize];
            partner != NONE && partner > *e && self.partner[partner as usize] == *e
        };
        (0..self.partner.len() as u32).filter(lower).map(|e| (e, self.width[e as usize]))
    }

    /// Has each pair closed, the narrowest first. Pairs that `close` declines look for others. Whether there was any.
    pub fn each_pair(&mut self, mut close: impl FnMut(usize, usize) -> bool) -> bool {
        let mut count = 0;
        for e in 0..self.partner.len() as u32 {
            let partner = self.partner[e as usize];
            if partner != NONE && partner > e && self.partner[partner as usize] == e {
                self.pairs[count] = e;
                count += 1;
            }
        }
        let (pairs, width) = (&mut self.pairs[..count], &*self.width);
        sort::by(pairs, |&a, &b| width[a as usize].total_cmp(&width[b as usize]).then(a.cmp(&b)));
        for &e in &*pairs {
            let f = self.partner[e as usize];
            if close(e as usize, f as usize) {
                (self.partner[e as usize], self.partner[f as usize]) = (e, f);
            } else {
                (self.refused[e as usize], self.refused[f as usize]) = (f, e);
            }
        }
        count > 0
    }
}

/// The power of two at or below a length; lengths that f64 hardly holds are one.
fn octave(length: f64) -> i64 {
    i64::from((length.to_bits() >> 52) as u32 & 0x7ff).max(1)
}

/// Cells of an octave are about as wide as what is looked for in it.
fn cell(octave: i64, p: DVec3, widest: f64) -> Cell {
    let length = f64::from_bits((octave as u64) << 52); // edges of the octave are up to twice as long
    let side = 4.0 * widest.min(length).max(f64::MIN_POSITIVE);
    let [x, y, z] = (p / side).to_array().map(|x| floor(x) as i64);
    [octave, x, y, z]
}
