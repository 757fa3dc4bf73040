//! A chart as a bit mask: every cell of a raster that the turned chart touches.
//!
//! Conservative: a cell is set if a border edge passes through it or its centre lies inside (winding number not 0).
//! Beside the bits stand up to 16 poles: cells deep inside, spread over the mask, whose squares must be free wherever the mask
//! is placed.

use super::outline::BorderEdge;
use super::poles::{self, Poles};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use glam::DVec2;

/// Border points this close to a cell's border, in cells, count for both cells: rounding of the turn is below 1e-12.
const NEAR: f64 = 1e-9;

/// One turned chart on the raster. Its memory is used again for the next.
pub(super) struct Mask<'a> {
    /// Cells.
    pub width: usize,
    pub height: usize,
    /// Words a row.
    pub words: usize,
    /// Local coordinates of the least corner of cell (0, 0).
    pub low: DVec2,
    /// Deepest first.
    pub poles: Poles,
    bits: &'a mut [u64], // (height, words)
    /// By how much the winding number changes before a cell: a byte each, 8 a word; then layers of the mask.
    changes: &'a mut [u64], // (height, width / 8 rounded up)
    limit: usize,
}

impl<'a> Mask<'a> {
    /// Bytes for masks of up to `limit` cells a side.
    pub fn need(limit: usize) -> usize {
        bytes_for::<u64>(limit * (limit / 64 + 1)) + bytes_for::<u64>(changes_len(limit))
    }

    /// An empty mask.
    pub fn new(limit: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            width: 0,
            height: 0,
            words: 0,
            low: DVec2::ZERO,
            poles: Poles::new(),
            bits: scratch.take(limit * (limit / 64 + 1))?,
            changes: scratch.take(changes_len(limit))?,
            limit,
        })
    }

    /// Words of a row.
    #[inline]
    pub fn row(&self, y: usize) -> &[u64] {
        &self.bits[y * self.words..(y + 1) * self.words]
    }

    /// Draws a chart after `turn`, with `cells` cells a unit; false if it is larger than the limit.
    /// `bounds` is the turned chart's box.
    pub fn draw(&mut self, edges: &[BorderEdge], bounds: [DVec2; 2], turn: DVec2, cells: f64) -> bool {
        let size = (bounds[1] - bounds[0]) * cells;
        if size.max_element() >= self.limit as f64 {
            return false;
        }
        self.low = bounds[0];
        (self.width, self.height) = (size.x as usize + 1, size.y as usize + 1);
        self.words = self.width.div_ceil(64);
        self.bits[..self.words * self.height].fill(0);
        self.changes[..self.width.div_ceil(8) * self.height].fill(0);
        // Where the last edge ended the next mostly begins.
        let mut last = [DVec2::NAN; 2];
        for edge in edges {
            let onto = |p: DVec2| (turn.rotate(p) - bounds[0]) * cells;
            let from = if edge[0] == last[0] { last[1] } else { onto(edge[0]) };
            last = [edge[1], onto(edge[1])];
            self.touch(from, last[1]);
        }
        self.fill_rows();
        poles::find(&mut self.poles, &self.bits[..self.words * self.height], self.width, self.height, self.changes);
        true
    }

    /// Sets the cells that a segment passes through, and counts its crossing of each row of cell centres.
    fn touch(&mut self, p: DVec2, q: DVec2) {
        let column = |x: f64| (x.max(0.0) as usize).min(self.width - 1);
        let (low, high) = if p.y <= q.y { (p, q) } else { (q, p) };
        let first = (low.y - NEAR).max(0.0) as usize;
        let last = ((high.y + NEAR).max(0.0) as usize).min(self.height - 1);
        let slope = if high.y > low.y { (high.x - low.x) / (high.y - low.y) } else { 0.0 };
        let at = |y: f64| if high.y > low.y { low.x + (y.clamp(low.y, high.y) - low.y) * slope } else { high.x };
        let mut a = if high.y > low.y { at(first as f64) } else { low.x };
        for y in first..=last {
            let b = at(y as f64 + 1.0);
            let (from, to) = (column(a.min(b) - NEAR), column(a.max(b) + NEAR));
            set(&mut self.bits[y * self.words..][..self.words], from, to);
            // A flat segment is as wide in each of its rows.
            if high.y > low.y {
                a = b;
            }
            let centre = y as f64 + 0.5;
            if low.y <= centre && centre < high.y {
                // The first cell whose centre is right of the crossing starts a new winding number.
                let x = (low.x + (centre - low.y) * slope + 0.5).max(0.0) as usize;
                if x < self.width {
                    let eight = &mut self.changes[y * self.width.div_ceil(8) + x / 8];
                    let change = if p.y < q.y { 1 } else { u64::MAX };
                    let own = 0xff << (x % 8 * 8);
                    *eight = *eight & !own | eight.wrapping_add(change << (x % 8 * 8)) & own;
                }
            }
        }
    }

    /// Winding numbers to bits, eight cells at a time where none changes.
    fn fill_rows(&mut self) {
        let beyond = self.width % 64;
        let rows = self.changes.rows(self.width.div_ceil(8));
        for (bits, changes) in self.bits.rows_mut(self.words).zip(rows).take(self.height) {
            let mut winding = 0u8;
            for (word, changes) in bits.iter_mut().zip(changes.chunks(8)) {
                for (i, eight) in changes.iter().enumerate() {
                    let mut inside = if winding != 0 { 0xff } else { 0 };
                    if *eight != 0 {
                        inside = 0;
                        for (cell, change) in eight.to_le_bytes().into_iter().enumerate() {
                            winding = winding.wrapping_add(change);
                            inside |= u64::from(winding != 0) << cell;
                        }
                    }
                    *word |= inside << (8 * i);
                }
            }
            if let Some(last) = bits.last_mut().filter(|_| beyond > 0) {
                *last &= (1 << beyond) - 1;
            }
        }
    }
}

/// Words for changes of the winding number, and for layers of the mask after that.
fn changes_len(limit: usize) -> usize {
    (limit.div_ceil(8) * limit).max(poles::room(limit, limit))
}

/// Sets the bits `from..=to` of a row.
fn set(row: &mut [u64], from: usize, to: usize) {
    let (first, last) = (u64::MAX << (from % 64), u64::MAX >> (63 - to % 64));
    let words = &mut row[from / 64..=to / 64];
    if let [word] = words {
        *word |= first & last;
    } else if let [begin, whole @ .., end] = words {
        *begin |= first;
        whole.fill(u64::MAX);
        *end |= last;
    }
}

#[cfg(test)]
mod tests {
    use super::super::poles::Pole;
    use super::*;
    use crate::base::random;
    use core::f64::consts::TAU;
    use std::{vec, vec::Vec};

    /// The mask of the same edges, cell by cell, and its poles.
    fn plainly(edges: &[BorderEdge], mask: &Mask, turn: DVec2, cells: f64) -> (Vec<bool>, Vec<Pole>) {
        let (w, h) = (mask.width as isize, mask.height as isize);
        let mut set = vec![false; (w * h) as usize];
        let mut winding = vec![0u8; (w * h) as usize];
        for edge in edges {
            let [p, q] = edge.map(|p| (turn.rotate(p) - mask.low) * cells);
            let (low, high) = if p.y <= q.y { (p, q) } else { (q, p) };
            let slope = if high.y > low.y { (high.x - low.x) / (high.y - low.y) } else { 0.0 };
            for y in (low.y - NEAR).max(0.0) as isize..=((high.y + NEAR).max(0.0) as isize).min(h - 1) {
                let at = |y: f64| low.x + (y.clamp(low.y, high.y) - low.y) * slope;
                let ends = if high.y > low.y { [at(y as f64), at(y as f64 + 1.0)] } else { [low.x, high.x] };
                let column = |x: f64| (x.max(0.0) as isize).min(w - 1);
                for x in column(ends[0].min(ends[1]) - NEAR)..=column(ends[0].max(ends[1]) + NEAR) {
                    set[(y * w + x) as usize] = true;
                }
                let centre = y as f64 + 0.5;
                let x = (low.x + (centre - low.y) * slope + 0.5).max(0.0) as isize;
                if low.y <= centre && centre < high.y {
                    let row = &mut winding[(y * w) as usize..((y + 1) * w) as usize];
                    let by = if p.y < q.y { 1 } else { u8::MAX };
                    row.iter_mut().skip(x as usize).for_each(|c| *c = c.wrapping_add(by));
                }
            }
        }
        set.iter_mut().zip(&winding).for_each(|(set, winding)| *set |= *winding != 0);
        let mut depth: Vec<u8> = set.iter().map(|s| if *s { 255 } else { 0 }).collect();
        let order: Vec<isize> = (0..w * h).collect();
        for (cells, ways) in [(order.clone(), 1), (order.into_iter().rev().collect(), -1)] {
            for at in cells {
                for (dx, dy) in [(-1, 0), (-1, -1), (0, -1), (1, -1)].map(|(dx, dy)| (dx * ways, dy * ways)) {
                    let (x, y) = (at % w + dx, at / w + dy);
                    let beside = if x >= 0 && x < w && y >= 0 && y < h { depth[(y * w + x) as usize] } else { 0 };
                    depth[at as usize] = depth[at as usize].min(beside.saturating_add(1));
                }
            }
        }
        let mut best = [Pole::default(); 16];
        for (x, y) in (0..h).rev().flat_map(|y| (0..w).map(move |x| (x, y))) {
            let (pole, depth) = (&mut best[(y * 4 / h * 4 + x * 4 / w) as usize], depth[(y * w + x) as usize]);
            if depth > pole.depth {
                *pole = Pole { x: x as i32, y: y as i32, depth };
            }
        }
        best.sort_by_key(|p| (255 - p.depth, p.y, p.x));
        (set, best.into_iter().filter(|p| p.depth > 0).collect())
    }

    /// Loops of `corners` about the origin, the second inside the first, the other way round or the same.
    fn loops(case: u64, corners: usize) -> Vec<BorderEdge> {
        let draw = |i: usize| random::unit_f64(case, 9, i as u64);
        let mut edges = vec![];
        for (size, way) in [(1.0, 1.0), (0.6, if case.is_multiple_of(2) { -1.0 } else { 1.0 })] {
            let points: Vec<DVec2> = (0..corners)
                .map(|i| {
                    let p = DVec2::from_angle(way * TAU * i as f64 / corners as f64) * size * (0.3 + 0.7 * draw(i));
                    // Some borders run along those of cells.
                    if case.is_multiple_of(3) { (p * 16.0).floor() / 16.0 } else { p }
                })
                .collect();
            edges.extend((0..corners).map(|i| [points[i], points[(i + 1) % corners]]));
        }
        edges
    }

    #[test]
    fn words_give_the_cells_and_poles_of_a_plain_mask() {
        let mut memory = vec![0; Mask::need(768) + 64];
        let mut scratch = Scratch::new(&mut memory);
        let mut mask = Mask::new(768, &mut scratch).unwrap();
        let mut widths = vec![];
        for case in 0..240 {
            // Every width up to some words, exactly whole ones among them, and a few squares deeper than a byte tells.
            let is_large = case % 60 == 59;
            let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
            let edges = match is_large {
                true => (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect(),
                false => loops(case, [3, 4, 7, 40][case as usize % 4]),
            };
            let turn = if is_large || case % 5 == 0 { DVec2::Y } else { DVec2::from_angle(case as f64) };
            let corners = edges.iter().flatten().map(|p| turn.rotate(*p));
            let [low, high] = corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[l, h], p| [l.min(p), h.max(p)]);
            let least = if case % 7 == 0 { low.floor() } else { low };
            let width = if is_large { 700.0 } else { case as f64 + 0.5 };
            let cells = (width / (high.x - least.x)).min(760.0 / (high.y - least.y));
            assert!(mask.draw(&edges, [least, high], turn, cells), "case {case}");
            let (set, poles) = plainly(&edges, &mask, turn, cells);
            for (at, set) in set.iter().enumerate() {
                let (x, y) = (at % mask.width, at / mask.width);
                assert_eq!(mask.row(y)[x / 64] >> (x % 64) & 1 == 1, *set, "case {case}, cell ({x}, {y})");
            }
            let beyond = (0..mask.height).map(|y| mask.row(y).iter().map(|w| w.count_ones() as usize).sum::<usize>());
            assert_eq!(beyond.sum::<usize>(), set.iter().filter(|s| **s).count(), "case {case}: bits beyond the width");
            assert_eq!(mask.poles[..], poles[..], "case {case}");
            widths.push(mask.width);
        }
        assert!([64, 128, 192].iter().all(|w| widths.contains(w)), "{widths:?}");
    }
}
