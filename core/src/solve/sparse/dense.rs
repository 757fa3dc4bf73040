//! Cholesky factorisation of the first columns of a dense matrix, block by block.
//!
//! Plain loops that `base::vector::wide` compiles for wider registers; columns behind a block are updated side by side
//! by the workers, each in the same order of sums: the same bits on all machines and for any number of threads.
//! Limit: a pivot that is not positive is replaced by a huge one, which holds that unknown where it is.

use crate::base::real::sqrt;
use crate::base::slices::Slices;
use crate::base::vector::wide;
use crate::base::workers::{Workers, for_each_chunk};
use core::ops::Range;

/// Columns that are eliminated one by one before the others of their block are updated.
const PANEL: usize = 8;
/// Columns that are eliminated before the ones behind them are updated: each is read and
/// written once a block.
const BLOCK: usize = 4 * PANEL;
/// Columns of one task.
const TASK: usize = 32;
/// Columns and rows that are updated together: 4 x 8 sums fill the registers of AVX2.
const TILE: usize = 4;
/// See [`TILE`].
const ROWS: usize = 8;

/// Eliminates the first `own` columns of the dense lower triangle `a` (m x m, by columns).
pub(super) fn partial_cholesky(a: &mut [f64], m: usize, own: usize, workers: &dyn Workers) {
    for first in (0..own).step_by(BLOCK) {
        let last = (first + BLOCK).min(own);
        let (head, behind) = a.parted_mut(last * m);
        let block = &mut head[first * m..];
        wide(
            #[inline(always)]
            || eliminate(block, m, first..last),
        );
        let block = &*block;
        for_each_chunk(workers, behind, TASK * m, &|task, columns| {
            wide(
                #[inline(always)]
                || update(columns, last + task * TASK, block, m),
            );
        });
    }
}

/// Eliminates the columns of a block, which are these columns of the matrix.
#[inline(always)]
fn eliminate(block: &mut [f64], m: usize, Range { start: first, end }: Range<usize>) {
    let count = end - first;
    let mut p = 0;
    while p < count {
        let width = PANEL.min(count - p);
        for j in p..p + width {
            let (head, tail) = block.parted_mut((j + 1) * m);
            let column = &mut head[j * m..];
            let row = first + j;
            let pivot = if column[row] > 0.0 { sqrt(column[row]) } else { 1e30 };
            column[row] = pivot;
            let inverse = 1.0 / pivot;
            column[row + 1..m].iter_mut().for_each(|x| *x *= inverse);
            for k in j + 1..p + width {
                let other = &mut tail[(k - j - 1) * m..(k - j) * m];
                let f = column[first + k];
                for (x, l) in other[first + k..].iter_mut().zip(&column[first + k..m]) {
                    *x -= f * l;
                }
            }
        }
        let (head, tail) = block.parted_mut((p + width) * m);
        update(tail, first + p + width, &head[p * m..], m);
        p += width;
    }
}

/// Subtracts what the eliminated columns `block` do to `columns`, of which the first is column `first` of the matrix.
#[inline(always)]
fn update(columns: &mut [f64], first: usize, block: &[f64], m: usize) {
    let mut k = first;
    let mut tiles = columns.rows_mut(TILE * m);
    for tile in &mut tiles {
        subtract::<TILE>(tile, block, m, k);
        k += TILE;
    }
    for (column, k) in tiles.into_rest().rows_mut(m).zip(k..) {
        subtract::<1>(column, block, m, k);
    }
}

/// The same for the `C` columns from `k` on, a few rows at a time: their sums stay in registers. Entries above the diagonal
/// change too; nobody reads them.
#[inline(always)]
fn subtract<const C: usize>(columns: &mut [f64], block: &[f64], m: usize, k: usize) {
    let mut row = k;
    while row + ROWS <= m {
        let mut sums = [[0.0; ROWS]; C];
        for l in block.rows(m) {
            let Some(rows) = l[row..].first_chunk::<ROWS>() else { continue };
            for (sum, f) in sums.iter_mut().zip(&l[k..k + C]) {
                sum.iter_mut().zip(rows).for_each(|(s, l)| *s += f * l);
            }
        }
        for (c, sum) in sums.iter().enumerate() {
            columns[c * m + row..][..ROWS].iter_mut().zip(sum).for_each(|(x, s)| *x -= s);
        }
        row += ROWS;
    }
    let left = m - row.min(m);
    if left > 0 && m >= ROWS {
        // Together with rows before them, which are done already.
        let mut sums = [[-0.0; ROWS]; C];
        for l in block.rows(m) {
            let Some(rows) = l.last_chunk::<ROWS>() else { continue };
            for (sum, f) in sums.iter_mut().zip(&l[k..k + C]) {
                sum.iter_mut().zip(rows).for_each(|(s, l)| *s += f * l);
            }
        }
        for (c, sum) in sums.iter().enumerate() {
            columns[c * m + row..][..left].iter_mut().zip(&sum[ROWS - left..]).for_each(|(x, s)| *x -= s);
        }
        return;
    }
    for row in row..m {
        for c in 0..C {
            let sum: f64 = block.rows(m).map(|l| l[k + c] * l[row]).sum();
            columns[c * m + row] -= sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use crate::base::workers::Serial;
    use std::{vec, vec::Vec};

    #[test]
    fn columns_times_their_transpose_give_back_the_matrix() {
        // Sizes on both sides of a panel, a tile, a block and a task; diagonally dominant, so positive definite.
        for m in [1, 3, 7, 8, 9, 20, 31, 33, 75] {
            let at = |r: usize, c: usize| if r == c { m as f64 } else { unit_f64(1, c as u64, r as u64) - 0.5 };
            let matrix: Vec<f64> = (0..m * m).map(|i| at(i % m, i / m)).collect();
            let mut a = matrix.clone();
            partial_cholesky(&mut a, m, m, &Serial);
            for (c, r) in (0..m).flat_map(|c| (c..m).map(move |r| (c, r))) {
                let product: f64 = (0..=c).map(|k| a[k * m + r] * a[k * m + c]).sum();
                // m products, each rounded once, of values below m.
                assert!((product - matrix[c * m + r]).abs() <= 4.0 * (m * m) as f64 * f64::EPSILON, "{m} {r} {c}");
            }
        }
    }

    #[test]
    fn what_is_left_is_the_schur_complement() {
        let (m, own) = (45, 37);
        let at = |r: usize, c: usize| if r == c { m as f64 } else { unit_f64(2, c as u64, r as u64) - 0.5 };
        let mut a: Vec<f64> = (0..m * m).map(|i| at((i % m).max(i / m), (i % m).min(i / m))).collect();
        let mut naive = a.clone();
        for k in 0..own {
            for (c, r) in (k + 1..m).flat_map(|c| (k + 1..m).map(move |r| (c, r))) {
                naive[c * m + r] -= naive[k * m + r] * naive[k * m + c] / naive[k * m + k];
            }
            // Rows of later columns read column k, which stays.
        }
        partial_cholesky(&mut a, m, own, &Serial);
        for (c, r) in (own..m).flat_map(|c| (c..m).map(move |r| (c, r))) {
            // 37 subtractions of products below 1 from values below 45.
            assert!((a[c * m + r] - naive[c * m + r]).abs() < 1e-12, "{r} {c}");
        }
    }

    #[test]
    fn wider_vectors_give_the_bits_of_the_plain_loops() {
        // Ragged rows and columns; one block, so that the two loops are all there is to it.
        for (m, own) in [(1, 1), (7, 3), (23, 8), (45, 29), (77, BLOCK)] {
            let at = |r: usize, c: usize| if r == c { m as f64 } else { unit_f64(4, c as u64, r as u64) - 0.5 };
            let mut plain: Vec<f64> = (0..m * m).map(|i| at(i % m, i / m)).collect();
            let mut vectors = plain.clone();
            partial_cholesky(&mut vectors, m, own, &Serial);
            let (block, behind) = plain.split_at_mut(own * m);
            eliminate(block, m, 0..own);
            behind.chunks_mut(TASK * m).enumerate().for_each(|(task, x)| update(x, own + task * TASK, block, m));
            let bits = |a: &[f64]| a.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&plain), bits(&vectors), "{m} {own}");
        }
    }

    #[test]
    fn a_pivot_of_zero_holds_its_unknown() {
        let mut a = vec![0.0, 1.0, 1.0, 2.0];
        partial_cholesky(&mut a, 2, 2, &Serial);
        assert!(a[0] >= 1e30 && a[1].abs() <= 1e-30 && a[3].is_finite());
    }
}
