//! Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi's rotations (Jacobi 1846; Golub, Van Loan, *Matrix
//! Computations*, 8.5).

use crate::base::real::sqrt;

/// Sweeps over all entries at the most: convergence is quadratic, and ten suffice for a hundred rows.
const SWEEPS: usize = 16;
/// Square sum of what is off the diagonal, over that of all, at which the matrix counts as diagonal.
const DIAGONAL: f64 = 1e-28;

/// Turns the symmetric `matrix` (n, n) diagonal; `vectors` (n, n) gets the eigenvector of entry k of the diagonal in its row k.
pub fn diagonalise(matrix: &mut [f64], vectors: &mut [f64], n: usize) {
    vectors.fill(0.0);
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    let all: f64 = matrix.iter().map(|x| x * x).sum();
    for _ in 0..SWEEPS {
        let below = (0..n).flat_map(|i| matrix[i * n..i * n + i].iter());
        let off: f64 = below.map(|x| x * x).sum();
        // Not so where a number is none: then nothing helps.
        if 2.0 * off <= DIAGONAL * all || off.is_nan() {
            return;
        }
        for p in 1..n {
            for q in 0..p {
                rotate(matrix, vectors, n, p, q);
            }
        }
    }
}

/// Clears the entry in row `p` and column `q`.
fn rotate(matrix: &mut [f64], vectors: &mut [f64], n: usize, p: usize, q: usize) {
    let off = matrix[p * n + q];
    if off == 0.0 {
        return;
    }
    let half = (matrix[q * n + q] - matrix[p * n + p]) / (2.0 * off);
    let tangent = if half < 0.0 { -1.0 } else { 1.0 } / (half.abs() + sqrt(half * half + 1.0));
    let cosine = 1.0 / sqrt(tangent * tangent + 1.0);
    let sine = tangent * cosine;
    let turn = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
    for k in 0..n {
        (matrix[k * n + p], matrix[k * n + q]) = turn(matrix[k * n + p], matrix[k * n + q]);
    }
    for k in 0..n {
        (matrix[p * n + k], matrix[q * n + k]) = turn(matrix[p * n + k], matrix[q * n + k]);
        (vectors[p * n + k], vectors[q * n + k]) = turn(vectors[p * n + k], vectors[q * n + k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use std::vec;

    #[test]
    fn rows_are_eigenvectors_and_orthonormal() {
        for n in [1, 2, 7, 40] {
            let mut a = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..=i {
                    a[i * n + j] = unit_f64(3, i as u64, j as u64) - 0.5;
                    a[j * n + i] = a[i * n + j];
                }
            }
            let (mut d, mut v) = (a.clone(), vec![0.0; n * n]);
            diagonalise(&mut d, &mut v, n);
            for k in 0..n {
                let row = &v[k * n..(k + 1) * n];
                for i in 0..n {
                    let image: f64 = (0..n).map(|j| a[i * n + j] * row[j]).sum();
                    // Rounding of n sums over entries below 1.
                    assert!((image - d[k * n + k] * row[i]).abs() < 1e-13 * n as f64, "{n}: {k} {i}");
                }
                for l in 0..=k {
                    let dot: f64 = (0..n).map(|j| row[j] * v[l * n + j]).sum();
                    assert!((dot - f64::from(u8::from(k == l))).abs() < 1e-13 * n as f64, "{n}: {k} {l}");
                }
            }
        }
    }
}
