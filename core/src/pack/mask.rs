//! A chart as a bit mask: every cell of a raster that the turned chart touches.
//!
//! Conservative: a cell is set if a border edge passes through it or its centre lies inside (winding number not 0).
//! Beside the bits stands each cell's chessboard distance to the nearest cell outside the mask, and from it up to 16
//! poles: cells deep inside, spread over the mask, whose squares must be free wherever the mask is placed.

use super::outline::BorderEdge;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use glam::DVec2;
use heapless::Vec;

/// Border points this close to a cell's border, in cells, count for both cells: rounding of the turn is below 1e-12.
const NEAR: f64 = 1e-9;

/// A square of cells inside the mask: all within `depth - 1` of (x, y).
#[derive(Clone, Copy, Debug)]
pub(super) struct Pole {
    pub x: i32,
    pub y: i32,
    pub depth: u8,
}

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
    pub poles: Vec<Pole, 16>,
    bits: &'a mut [u64], // (height, words)
    depth: &'a mut [u8], // (height, width)
    limit: usize,
}

impl<'a> Mask<'a> {
    /// Bytes for masks of up to `limit` cells a side.
    pub fn need(limit: usize) -> usize {
        bytes_for::<u64>(limit * (limit / 64 + 1)) + bytes_for::<u8>(limit * limit)
    }

    /// An empty mask.
    pub fn new(limit: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            width: 0,
            height: 0,
            words: 0,
            low: DVec2::ZERO,
            poles: Vec::new(),
            bits: scratch.take(limit * (limit / 64 + 1))?,
            depth: scratch.take(limit * limit)?,
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
        self.depth[..self.width * self.height].fill(0);
        for edge in edges {
            let [p, q] = edge.map(|p| (turn.rotate(p) - bounds[0]) * cells);
            self.touch(p, q);
        }
        self.fill_rows();
        self.deepen();
        true
    }

    /// Sets the cells that a segment passes through, and counts its crossing of each row of cell centres.
    fn touch(&mut self, p: DVec2, q: DVec2) {
        let column = |x: f64| (x.max(0.0) as usize).min(self.width - 1);
        let (low, high) = if p.y <= q.y { (p, q) } else { (q, p) };
        let first = (low.y - NEAR).max(0.0) as usize;
        let last = ((high.y + NEAR).max(0.0) as usize).min(self.height - 1);
        let slope = if high.y > low.y { (high.x - low.x) / (high.y - low.y) } else { 0.0 };
        for y in first..=last {
            let at = |y: f64| if high.y > low.y { low.x + (y.clamp(low.y, high.y) - low.y) * slope } else { low.x };
            let (mut a, mut b) = (at(y as f64), at(y as f64 + 1.0));
            if high.y <= low.y {
                (a, b) = (low.x, high.x);
            }
            let (from, to) = (column(a.min(b) - NEAR), column(a.max(b) + NEAR));
            for x in from..=to {
                self.bits[y * self.words + x / 64] |= 1 << (x % 64);
            }
            let centre = y as f64 + 0.5;
            if low.y <= centre && centre < high.y {
                // The first cell whose centre is right of the crossing starts a new winding number.
                let x = (low.x + (centre - low.y) * slope + 0.5).max(0.0) as usize;
                if x < self.width {
                    let cell = &mut self.depth[y * self.width + x];
                    *cell = if p.y < q.y { cell.wrapping_add(1) } else { cell.wrapping_sub(1) };
                }
            }
        }
    }

    /// Winding numbers to bits; set cells get depth 255, others 0.
    fn fill_rows(&mut self) {
        for y in 0..self.height {
            let (row, bits) = (&mut self.depth[y * self.width..][..self.width], &mut self.bits[y * self.words..]);
            let mut winding = 0u8;
            for (x, cell) in row.iter_mut().enumerate() {
                winding = winding.wrapping_add(*cell);
                if winding != 0 {
                    bits[x / 64] |= 1 << (x % 64);
                }
                *cell = if bits[x / 64] >> (x % 64) & 1 == 1 { 255 } else { 0 };
            }
        }
    }

    /// Chessboard distances to the outside in two passes, then the deepest cell of each of 4 x 4 parts.
    fn deepen(&mut self) {
        let (w, h) = (self.width, self.height);
        let depth = &mut self.depth[..w * h];
        for y in 0..h {
            let (above, rest) = depth.parted_mut(y * w);
            relax_row(&mut rest[..w], above.len().checked_sub(w).map(|last| &above[last..]), false);
        }
        let mut best = [Pole { x: 0, y: 0, depth: 0 }; 16];
        for y in (0..h).rev() {
            let (rest, below) = depth.parted_mut((y + 1) * w);
            let row = &mut rest[y * w..];
            relax_row(row, below.get(..w), true);
            let part = &mut best[y * 4 / h * 4..][..4];
            for (i, pole) in part.iter_mut().enumerate() {
                let first = (i * w).div_ceil(4);
                for (x, &depth) in row[first..((i + 1) * w).div_ceil(4)].iter().enumerate() {
                    if depth > pole.depth {
                        *pole = Pole { x: (first + x) as i32, y: y as i32, depth };
                    }
                }
            }
        }
        sort::by_key(&mut best, |p| (255 - p.depth, p.y, p.x));
        self.poles.clear();
        best.into_iter().filter(|p| p.depth > 0).for_each(|p| _ = self.poles.push(p));
    }
}

/// One row of a chessboard distance pass: each cell at most one more than its neighbour before it in the row and the
/// three of the row passed before; what lies outside the mask has distance 0.
fn relax_row(row: &mut [u8], passed: Option<&[u8]>, backwards: bool) {
    let last = row.len() - 1;
    let Some(passed) = passed else {
        return row.iter_mut().for_each(|d| *d = (*d).min(1));
    };
    for (d, three) in row[1..].iter_mut().zip(passed.windows(3)) {
        *d = (*d).min(three[0].min(three[1]).min(three[2]).saturating_add(1));
    }
    (row[0], row[last]) = (row[0].min(1), row[last].min(1));
    let mut before = 0u8;
    let step = |d: &mut u8| {
        *d = (*d).min(before.saturating_add(1));
        before = *d;
    };
    if backwards { row.iter_mut().rev().for_each(step) } else { row.iter_mut().for_each(step) }
}
