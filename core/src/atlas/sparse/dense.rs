//! Cholesky factorisation of the first columns of a dense matrix, panel by panel.
//!
//! Plain loops that `base::vector::wide` compiles for wider registers; the same bits on all.
//! Limit: a pivot that is not positive is replaced by a huge one, which holds that unknown where it is.

use crate::base::real::sqrt;

/// Columns of a dense panel. 4: 20 % slower; 16: the same.
const PANEL: usize = 8;

/// Eliminates the first `own` columns of the dense lower triangle `a` (m x m, by columns).
#[inline(always)]
pub(super) fn partial_cholesky(a: &mut [f64], m: usize, own: usize) {
    let mut p = 0;
    while p < own {
        let width = PANEL.min(own - p);
        for j in p..p + width {
            let (head, tail) = a.split_at_mut((j + 1) * m);
            let column = &mut head[j * m..];
            let pivot = if column[j] > 0.0 { sqrt(column[j]) } else { 1e30 };
            column[j] = pivot;
            let inverse = 1.0 / pivot;
            column[j + 1..m].iter_mut().for_each(|x| *x *= inverse);
            for k in j + 1..p + width {
                let other = &mut tail[(k - j - 1) * m..(k - j) * m];
                let f = column[k];
                for (x, l) in other[k..].iter_mut().zip(&column[k..m]) {
                    *x -= f * l;
                }
            }
        }
        let (head, tail) = a.split_at_mut((p + width) * m);
        let panel = &head[p * m..];
        for k in p + width..m {
            let column = &mut tail[(k - p - width) * m + k..(k - p - width + 1) * m];
            if width == PANEL {
                subtract_panel(column, panel, m, k);
            } else {
                for j in 0..width {
                    let l = &panel[j * m + k..(j + 1) * m];
                    let f = l[0];
                    for (x, l) in column.iter_mut().zip(l) {
                        *x -= f * l;
                    }
                }
            }
        }
        p += width;
    }
}

/// column -= sum over the panel's columns of its entry at row k times its rows from k on.
#[inline(always)]
fn subtract_panel(column: &mut [f64], panel: &[f64], m: usize, k: usize) {
    let n = column.len();
    let l: [&[f64]; PANEL] = core::array::from_fn(|j| &panel[j * m + k..j * m + k + n]);
    let f: [f64; PANEL] = core::array::from_fn(|j| l[j][0]);
    for i in 0..n {
        let a = (f[0] * l[0][i] + f[1] * l[1][i]) + (f[2] * l[2][i] + f[3] * l[3][i]);
        let b = (f[4] * l[4][i] + f[5] * l[5][i]) + (f[6] * l[6][i] + f[7] * l[7][i]);
        column[i] -= a + b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use std::{vec, vec::Vec};

    #[test]
    fn columns_times_their_transpose_give_back_the_matrix() {
        // Sizes on both sides of a panel; diagonally dominant, so positive definite.
        for m in [1, 7, 8, 9, 20] {
            let at = |r: usize, c: usize| if r == c { m as f64 } else { unit_f64(1, c as u64, r as u64) - 0.5 };
            let matrix: Vec<f64> = (0..m * m).map(|i| at(i % m, i / m)).collect();
            let mut a = matrix.clone();
            partial_cholesky(&mut a, m, m);
            for (c, r) in (0..m).flat_map(|c| (c..m).map(move |r| (c, r))) {
                let product: f64 = (0..=c).map(|k| a[k * m + r] * a[k * m + c]).sum();
                // m products, each rounded once, of values below m.
                assert!((product - matrix[c * m + r]).abs() <= 4.0 * (m * m) as f64 * f64::EPSILON, "{m} {r} {c}");
            }
        }
    }

    #[test]
    fn a_pivot_of_zero_holds_its_unknown() {
        let mut a = vec![0.0, 1.0, 1.0, 2.0];
        partial_cholesky(&mut a, 2, 2);
        assert!(a[0] >= 1e30 && a[1].abs() <= 1e-30 && a[3].is_finite());
    }
}
