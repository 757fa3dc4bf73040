//! The plain path: rows of C in array code, for every machine and both number types; the reference of the others.

use super::number::Number;
use super::task::{RowTask, SLAB, panel_of, steps};
use crate::base::slices::Slices;

/// Columns of a tile and of a packed panel.
pub(super) const WIDTH: usize = 8;
const HEIGHT: usize = 4;

/// Adds A B to rows of C with `fused(a, b, c)` at each step; see [`super::float::Float::fill_rows`].
pub(super) fn fill_rows<T: Number>(task: RowTask<T>, fused: impl Fn(T, T, T) -> T + Copy) {
    let RowTask { rows, columns, depth, a, packed, begins_at_zero } = task;
    let Some(count) = rows.len().checked_div(columns) else { return };
    for slab in (0..depth).step_by(SLAB).map(|k| k..(k + SLAB).min(depth)) {
        for row in (0..count).step_by(HEIGHT) {
            let height = HEIGHT.min(count - row);
            let mut left = [[T::ZERO; HEIGHT]; SLAB];
            steps(a, row, row + height, slab.clone(), |k, step| left[k] = step);
            let begins = begins_at_zero && slab.start == 0;
            for column in (0..columns).step_by(WIDTH) {
                let width = WIDTH.min(columns - column);
                let panel = &packed[panel_of(&slab, column, columns, WIDTH)];
                let mut tile = [[T::ZERO; WIDTH]; HEIGHT];
                for (r, line) in tile.iter_mut().enumerate().take(if begins { 0 } else { height }) {
                    line[..width].copy_from(&rows[(row + r) * columns + column..][..width]);
                }
                for (x, y) in left.iter().zip(panel.as_chunks::<WIDTH>().0) {
                    for (line, &x) in tile.iter_mut().zip(x) {
                        line.iter_mut().zip(y).for_each(|(c, &y)| *c = fused(x, y, *c));
                    }
                }
                for (r, line) in tile.iter().enumerate().take(height) {
                    rows[(row + r) * columns + column..][..width].copy_from(&line[..width]);
                }
            }
        }
    }
}
