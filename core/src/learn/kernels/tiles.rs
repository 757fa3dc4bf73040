//! The walk over tiles that paths of vector instructions share: 6 rows and a few vectors of columns, held in registers
//! over a slab.
//!
//! One macro writes it for each kind of vector: its lanes, how many make a row of the tile, and the five operations of
//! `core::arch` that it takes. `unsafe` lives here: instructions that the caller has found, and loads and stores through
//! pointers whose bounds are those of slices taken just before.

use super::task::PACKED_ROWS;

/// Rows of a tile: 6 x 2 sums, 2 loads and a broadcast fill AVX2's 16 registers; 6 x 4, 4 and 1 the 32 of AVX-512 and
/// NEON.
pub(super) const HEIGHT: usize = 6;
const _: () = assert!(PACKED_ROWS.is_multiple_of(HEIGHT));

macro_rules! tiles {
    ($module:ident, $features:literal, $lanes:literal, $vectors:literal, $vector:ident, $load:ident, $store:ident,
     $broadcast:ident, $fused:ident) => {
        mod $module {
            use super::*;
            use crate::base::slices::Slices;
            use crate::learn::kernels::task::{PACKED_ROWS, RowTask, SLAB, panel_of, steps};
            use crate::learn::kernels::tiles::HEIGHT;
            use core::mem::MaybeUninit;

            pub const WIDTH: usize = $lanes * $vectors;

            /// SAFETY: the machine has the instructions and `packed` holds all panels of `depth` rows.
            #[target_feature(enable = $features)]
            pub unsafe fn fill_rows(task: RowTask<f32>) {
                // Rows of A that lie along the depth are read where they are; others are packed first.
                // SAFETY: the caller's.
                unsafe {
                    if task.a.column == 1 {
                        walk::<1>(task);
                    } else {
                        walk::<{ PACKED_ROWS / HEIGHT }>(task);
                    }
                }
            }

            /// [`fill_rows`] with memory for `TILES` packed tiles of A; with 1 only a ragged last tile is packed.
            /// SAFETY: that of [`fill_rows`].
            #[target_feature(enable = $features)]
            unsafe fn walk<const TILES: usize>(task: RowTask<f32>) {
                let RowTask { rows, columns, depth, a, packed, begins_at_zero } = task;
                let Some(count) = rows.len().checked_div(columns) else { return };
                // Clearing it would take a tenth of a small product's time.
                let mut left = [[MaybeUninit::<[f32; HEIGHT]>::uninit(); SLAB]; TILES];
                for slab in (0..depth).step_by(SLAB).map(|k| k..(k + SLAB).min(depth)) {
                    let begins = begins_at_zero && slab.start == 0;
                    for block in (0..count).step_by(if TILES == 1 { count.max(1) } else { TILES * HEIGHT }) {
                        let end = if TILES == 1 { count } else { (block + TILES * HEIGHT).min(count) };
                        let is_direct = |row: usize| TILES == 1 && row + HEIGHT <= end;
                        // With one tile of memory that is the last, ragged one.
                        let first = if TILES == 1 { end / HEIGHT * HEIGHT } else { block };
                        for (row, out) in (first..end).step_by(HEIGHT).zip(&mut left) {
                            steps(a, row, end.min(row + HEIGHT), slab.clone(), |k, step| _ = out[k].write(step));
                        }
                        for column in (0..columns).step_by(WIDTH) {
                            let panel = &packed[panel_of(&slab, column, columns, WIDTH)];
                            for (i, row) in (block..end).step_by(HEIGHT).enumerate() {
                                let left = if is_direct(row) {
                                    let rows = &a.data[row * a.row..][..(HEIGHT - 1) * a.row + slab.end];
                                    (rows[slab.start..].as_ptr(), a.row, 1)
                                } else {
                                    (left[if TILES == 1 { 0 } else { i }].as_ptr().cast(), 1, HEIGHT)
                                };
                                let (height, width) = (HEIGHT.min(end - row), WIDTH.min(columns - column));
                                let at = row * columns + column;
                                if height == HEIGHT && width == WIDTH {
                                    let rows = &mut rows[at..][..(HEIGHT - 1) * columns + WIDTH];
                                    // SAFETY: these are the tile's six rows.
                                    unsafe { tile(rows.as_mut_ptr(), columns, left, panel, begins) };
                                } else {
                                    let mut edge = [0.0; HEIGHT * WIDTH];
                                    for r in 0..height {
                                        let from = &rows[at + r * columns..][..width];
                                        edge[r * WIDTH..][..width].copy_from(from);
                                    }
                                    // SAFETY: the tile is the whole of `edge`.
                                    unsafe { tile(edge.as_mut_ptr(), WIDTH, left, panel, begins) };
                                    for r in 0..height {
                                        let to = &mut rows[at + r * columns..][..width];
                                        to.copy_from(&edge[r * WIDTH..][..width]);
                                    }
                                }
                            }
                        }
                    }
                }
            }

            /// Adds left times panel (WIDTH values a step) to a tile of C, or to zero. `left` is a pointer, the distance of
            /// its rows and that of its steps.
            /// SAFETY: HEIGHT rows of WIDTH values, `stride` apart, can be read and written at `c`; HEIGHT rows of as many
            /// steps as `panel` has can be read at `left`.
            #[target_feature(enable = $features)]
            #[inline]
            unsafe fn tile(
                c: *mut f32,
                stride: usize,
                left: (*const f32, usize, usize),
                panel: &[f32],
                begins_at_zero: bool,
            ) {
                let mut sums = [[$broadcast(0.0); $vectors]; HEIGHT];
                // SAFETY: the caller's rows and steps.
                unsafe {
                    if !begins_at_zero {
                        for r in 0..HEIGHT {
                            for v in 0..$vectors {
                                sums[r][v] = $load(c.add(r * stride + v * $lanes));
                            }
                        }
                    }
                    let (mut x, row, step) = left;
                    let mut y = panel.as_ptr();
                    for _ in 0..panel.len() / WIDTH {
                        let mut right: [$vector; $vectors] = [$broadcast(0.0); $vectors];
                        for v in 0..$vectors {
                            right[v] = $load(y.add(v * $lanes));
                        }
                        for r in 0..HEIGHT {
                            let value = $broadcast(*x.add(r * row));
                            for v in 0..$vectors {
                                sums[r][v] = $fused(value, right[v], sums[r][v]);
                            }
                        }
                        (x, y) = (x.wrapping_add(step), y.wrapping_add(WIDTH));
                    }
                    for r in 0..HEIGHT {
                        for v in 0..$vectors {
                            $store(c.add(r * stride + v * $lanes), sums[r][v]);
                        }
                    }
                }
            }
        }
    };
}
