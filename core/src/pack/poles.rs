//! Poles of a bit mask: the deepest cell of each of 4 x 4 parts, whose squares must be free wherever the mask is placed.
//!
//! A cell's depth is its chessboard distance to the nearest cell outside the mask. Layers are peeled off the mask, 64 cells at a
//! time, and a part's pole is the cell that goes last: the uppermost, then leftmost of those.
//! Cost: a few steps for each 64 cells of the rows that are left, in each of as many layers as the mask is deep.

use crate::base::slices::Slices;
use crate::base::sort;
use core::mem::swap;
use heapless::Vec;

/// A square of cells inside the mask: all within `depth - 1` of (x, y).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pole {
    pub x: i32,
    pub y: i32,
    pub depth: u8,
}

/// Parts of a side.
const PARTS: usize = 4;

/// At most one a part, deepest first.
pub(super) type Poles = Vec<Pole, { PARTS * PARTS }>;

/// Words of memory that [`find`] takes for a mask of `width` x `height` cells.
pub(super) fn room(width: usize, height: usize) -> usize {
    2 * layer_len(width, height)
}

/// Rows of a layer end with a bit that is not set; there is a word before them and one behind.
fn layer_len(width: usize, height: usize) -> usize {
    (width / 64 + 1) * height + 2
}

/// Finds the poles of a mask of `width` cells a row.
pub(super) fn find(poles: &mut Poles, bits: &[u64], width: usize, height: usize, room: &mut [u64]) {
    let words = width / 64 + 1;
    let (layer, peeled) = room.parted_mut(layer_len(width, height));
    let rows = bits.rows(width.div_ceil(64));
    for (to, from) in layer[1..].rows_mut(words).zip(rows) {
        to.fill(0);
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }
    let mut best = [Pole::default(); PARTS * PARTS];
    peel_off(&mut best, layer, peeled, width, height);
    sort::by_key(&mut best, |p| (255 - p.depth, p.y, p.x));
    poles.clear();
    best.into_iter().filter(|p| p.depth > 0).for_each(|p| _ = poles.push(p));
}

/// Peels a mask; each part's pole.
fn peel_off<'l>(
    best: &mut [Pole; PARTS * PARTS],
    mut layer: &'l mut [u64],
    mut peeled: &'l mut [u64],
    width: usize,
    height: usize,
) {
    let words = width / 64 + 1;
    let border = |i: usize, size: usize| (i * size).div_ceil(PARTS);
    let mut left = [true; PARTS * PARTS];
    for (i, pole) in best.iter_mut().enumerate() {
        (pole.x, pole.y) = (border(i % PARTS, width) as i32, border(i / PARTS + 1, height) as i32 - 1);
    }
    for depth in 1..=u8::MAX {
        // Other rows have nothing any more.
        let (first, end) = (usize::from(depth) - 1, height.saturating_sub(usize::from(depth) - 1));
        for (i, (pole, left)) in best.iter_mut().zip(&mut left).enumerate().filter(|(_, (_, left))| **left) {
            let columns = [border(i % PARTS, width), border(i % PARTS + 1, width)];
            let rows = [border(i / PARTS, height).max(first), end];
            match next_set(layer, words, [pole.x as usize, pole.y as usize], columns, rows) {
                Some([x, y]) => *pole = Pole { x: x as i32, y: y as i32, depth },
                None => *left = false,
            }
        }
        if end < first + 3 || !left.contains(&true) {
            return;
        }
        let count = (end - first - 2) * words;
        peel(&layer[first * words..], &mut peeled[1 + (first + 1) * words..][..count], words);
        swap(&mut layer, &mut peeled);
    }
}

/// The cells whose eight neighbours are set; the first of the rows of `from`, of which there are two more, stands behind one word.
fn peel(from: &[u64], to: &mut [u64], words: usize) {
    let count = to.len() + 2;
    let rows = [&from[..count], &from[words..][..count], &from[2 * words..][..count]].map(|r| r.windows(3));
    let [above, row, below] = rows;
    for (((to, a), b), c) in to.iter_mut().zip(above).zip(row).zip(below) {
        let (before, here, behind) = (a[0] & b[0] & c[0], a[1] & b[1] & c[1], a[2] & b[2] & c[2]);
        *to = here & (here << 1 | before >> 63) & (here >> 1 | behind << 63);
    }
}

/// The first set cell from (x, y) on, rightwards within the columns and then from the row below them.
fn next_set(
    layer: &[u64],
    words: usize,
    [x, y]: [usize; 2],
    columns: [usize; 2],
    rows: [usize; 2],
) -> Option<[usize; 2]> {
    let mut from = if y < rows[1] { x } else { columns[0] };
    for y in (rows[0]..rows[1].min(y + 1)).rev() {
        let row = &layer[1 + y * words..][..words];
        while from < columns[1] {
            let rest = row[from / 64] >> (from % 64);
            if rest != 0 {
                from += rest.trailing_zeros() as usize;
                break;
            }
            from = (from / 64 + 1) * 64;
        }
        if from < columns[1] {
            return Some([from, y]);
        }
        from = columns[0];
    }
    None
}
