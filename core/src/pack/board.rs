//! The raster square that charts are placed on: what is blocked, and how far each cell is from that.
//!
//! Beside the bits stands the chessboard distance of every cell to the nearest blocked one (kept up to date as far as
//! later masks need it; larger values are upper bounds), so that one look-up at a mask's deepest cell rejects most places.
//! A free place is one where no bit of the mask is blocked; distances only save comparing bits.

use super::mask::Mask;
use super::placement::Gap;
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use core::ops::Range;

/// The raster square: what is blocked, and how far each cell is from that.
pub(super) struct Board<'a> {
    side: usize,
    pub usable: usize,      // cells a side that charts may take
    blocked: &'a mut [u64], // (side, side / 64)
    distance: &'a mut [u8], // (side, side): chessboard, up to 255
    farthest: &'a mut [u8], // (side, side / 64): largest distance in 64 cells
    buffer: &'a mut [u64],  // a row
}

impl<'a> Board<'a> {
    /// Bytes for a board of `side` cells, a multiple of 64.
    pub fn need(side: usize) -> usize {
        bytes_for::<u64>(side * (side / 64))
            + bytes_for::<u8>(side * side)
            + bytes_for::<u8>(side * (side / 64))
            + bytes_for::<u64>(side / 64 + 2)
    }

    /// An empty board.
    pub fn new(side: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            side,
            usable: side,
            blocked: scratch.take(side * (side / 64))?,
            distance: scratch.take(side * side)?,
            farthest: scratch.take(side * (side / 64))?,
            buffer: scratch.take(side / 64 + 2)?,
        })
    }

    /// Leaves out the last cells where that saves a cell of padding; the padding in cells.
    pub fn fit(&mut self, gap: &Gap) -> f64 {
        let share = gap.texels / gap.size;
        let whole = real::floor(share * self.side as f64);
        let usable = if whole > 0.0 { real::floor(whole / share) as usize } else { 0 };
        self.usable = if usable * 64 > self.side * 63 { usable.min(self.side) } else { self.side };
        share * self.usable as f64
    }

    /// Nothing is blocked.
    pub fn clear(&mut self) {
        self.blocked.fill(0);
        self.distance.fill(255);
        self.farthest.fill(255);
    }

    /// The lowest, then leftmost free place at or above row `floor` whose upper end is at most `limit`.
    pub fn lowest(&self, mask: &Mask, floor: usize, limit: usize) -> Option<(usize, usize)> {
        let (side, words) = (self.side, self.side / 64);
        let pole = mask.poles.first()?;
        let (px, py) = (pole.x as usize, pole.y as usize);
        if mask.width > self.usable {
            return None;
        }
        let (first, last) = (px, self.usable + px - mask.width);
        for y in floor..(limit + 1).checked_sub(mask.height)? {
            let row = &self.distance[(y + py) * side..][..side];
            let far = &self.farthest[(y + py) * words..][..words];
            for (block, _) in far.iter().enumerate().take(last / 64 + 1).skip(first / 64).filter(|f| *f.1 >= pole.depth)
            {
                let from = first.max(block * 64);
                let cells = &row[from..last.min(block * 64 + 63) + 1];
                for (i, _) in cells.iter().enumerate().filter(|c| *c.1 >= pole.depth) {
                    let x = from + i - px;
                    if self.poles_free(mask, x, y) && self.bits_free(mask, x, y) {
                        return Some((x, y));
                    }
                }
            }
        }
        None
    }

    #[inline]
    fn poles_free(&self, mask: &Mask, x: usize, y: usize) -> bool {
        let at = y * self.side + x;
        mask.poles.iter().skip(1).all(|p| self.distance[at + p.y as usize * self.side + p.x as usize] >= p.depth)
    }

    fn bits_free(&self, mask: &Mask, x: usize, y: usize) -> bool {
        let words = self.side / 64;
        let (word, shift) = (x / 64, x % 64);
        // Every seventh row first: neighbours tell much the same.
        for (first, step) in [(3, 7), (0, 1)] {
            let mut next = first;
            while next < mask.height {
                let row = next;
                next += step;
                let line = &self.blocked[(y + row) * words + word..(y + row + 1) * words];
                let mut carry = 0u64;
                for (i, &bits) in mask.row(row).iter().enumerate() {
                    let moved = bits << shift | carry;
                    carry = if shift == 0 { 0 } else { bits >> (64 - shift) };
                    if moved & line[i] != 0 {
                        return false;
                    }
                }
                if carry != 0 && line[mask.words] & carry != 0 {
                    return false;
                }
            }
        }
        true
    }

    /// Blocks the mask at (x, y) grown by `grow` cells, and brings distances up to `depth` cells up to date.
    pub fn block(&mut self, mask: &Mask, x: usize, y: usize, grow: f64, depth: usize) {
        let (side, words) = (self.side as isize, self.side / 64);
        let reach = real::ceil(grow) as isize + 1;
        for dy in -reach..=reach {
            // Cells dx apart leave |dx| - 1 cells between them: blocked if that gap is closer than `grow`.
            let between = (dy.abs() - 1).max(0) as f64;
            if between >= grow && dy != 0 {
                continue;
            }
            let across = real::sqrt((grow * grow - between * between).max(0.0));
            let spread = (real::ceil(across) as isize).min(self.side as isize);
            for row in 0..mask.height {
                let to = y as isize + row as isize + dy;
                if (0..side).contains(&to) {
                    shift_into(self.buffer, mask.row(row), x);
                    smear(self.buffer, spread as usize);
                    let line = &mut self.blocked[to as usize * words..][..words];
                    line.iter_mut().zip(self.buffer.iter()).for_each(|(l, b)| *l |= b);
                }
            }
        }
        let grown = reach as usize;
        let cap = depth.min(256);
        let rows = (y.saturating_sub(grown), (y + mask.height + grown).min(self.side));
        let columns = (x.saturating_sub(grown), (x + mask.width + grown).min(self.side));
        for row in rows.0..rows.1 {
            for column in columns.0..columns.1 {
                if self.blocked[row * words + column / 64] >> (column % 64) & 1 == 1 {
                    self.distance[row * self.side + column] = 0;
                }
            }
        }
        self.relax(
            (rows.0.saturating_sub(cap), (rows.1 + cap).min(self.side)),
            (columns.0.saturating_sub(cap), (columns.1 + cap).min(self.side)),
        );
    }

    /// Lowers distances in a window after cells in it were set to 0; two passes, cells outside stay.
    fn relax(&mut self, rows: (usize, usize), columns: (usize, usize)) {
        let (side, words) = (self.side, self.side / 64);
        let window = columns.0..columns.1;
        for y in rows.0.max(1)..rows.1 {
            let (above, here) = self.distance.parted_mut(y * side);
            relax_row(&mut here[..side], &above[(y - 1) * side..], window.clone(), false);
        }
        for y in (rows.0..rows.1).rev() {
            let (here, below) = self.distance.parted_mut((y + 1) * side);
            let row = &mut here[y * side..];
            if !below.is_empty() {
                relax_row(row, &below[..side], window.clone(), true);
            }
            for block in columns.0 / 64..columns.1.div_ceil(64) {
                let cells = &row[block * 64..][..64];
                self.farthest[y * words + block] = cells.iter().copied().max().unwrap_or(0);
            }
        }
    }
}

/// One row of a chessboard distance pass over a window of columns. The board's border blocks nothing.
fn relax_row(row: &mut [u8], passed: &[u8], window: Range<usize>, backwards: bool) {
    let side = row.len();
    let inner = window.start.max(1)..window.end.min(side - 1);
    for (d, three) in row[inner.clone()].iter_mut().zip(passed[inner.start - 1..inner.end + 1].windows(3)) {
        *d = (*d).min(three[0].min(three[1]).min(three[2]).saturating_add(1));
    }
    for x in [0, side - 1].into_iter().filter(|x| window.contains(x)) {
        let beside = if x == 0 { 1 } else { side - 2 };
        row[x] = row[x].min(passed[x].min(passed[beside]).saturating_add(1));
    }
    let mut before = match backwards {
        true => row.get(window.end).copied().unwrap_or(255),
        false => window.start.checked_sub(1).map_or(255, |x| row[x]),
    };
    let step = |d: &mut u8| {
        *d = (*d).min(before.saturating_add(1));
        before = *d;
    };
    if backwards { row[window].iter_mut().rev().for_each(step) } else { row[window].iter_mut().for_each(step) }
}

/// `bits` moved up by `x` places into `row`; what leaves the row is lost.
fn shift_into(row: &mut [u64], bits: &[u64], x: usize) {
    row.fill(0);
    let (word, shift) = (x / 64, x % 64);
    for (i, &b) in bits.iter().enumerate() {
        if let Some(r) = row.get_mut(word + i) {
            *r |= b << shift;
        }
        if shift > 0
            && let Some(r) = row.get_mut(word + i + 1)
        {
            *r |= b >> (64 - shift);
        }
    }
}

/// Sets every bit within `spread` places of a set bit.
fn smear(row: &mut [u64], spread: usize) {
    let mut left = spread;
    let mut reach = 1;
    while left > 0 {
        let by = reach.min(left).min(63);
        let mut carry = 0;
        for r in row.iter_mut() {
            let before = *r;
            *r |= before << by | carry;
            carry = before >> (64 - by);
        }
        carry = 0;
        for r in row.iter_mut().rev() {
            let before = *r;
            *r |= before >> by | carry;
            carry = before << (64 - by);
        }
        left -= by;
        reach = 2 * by + 1;
    }
}
