//! AVX2 and AVX-512 paths: tiles of 6 x 16 and 6 x 64.
//!
//! `unsafe` lives here: instructions found at run time.

use super::path::{Path, has};
use super::task::{RowTask, padded};
use core::arch::x86_64::*;

/// Columns of a packed panel.
pub(super) fn panel(path: Path) -> usize {
    if path == Path::Avx512 { wide512::WIDTH } else { wide256::WIDTH }
}

/// See [`super::float::Float::fill_rows`]. Does nothing where the machine lacks the instructions: `product` asks first.
pub(super) fn fill_rows(path: Path, mut task: RowTask<f32>) {
    task.packed = &task.packed[..padded(task.columns, panel(path)) * task.depth];
    match path {
        // SAFETY: the instructions are there, as just found, and the packed panels are complete.
        Path::Avx512 if has(path) => unsafe { wide512::fill_rows(task) },
        // SAFETY: as above.
        Path::Avx2 if has(path) => unsafe { wide256::fill_rows(task) },
        _ => debug_assert!(false, "the machine has no {path:?}"),
    }
}

tiles!(wide256, "avx2,fma", 8, 2, __m256, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_set1_ps, _mm256_fmadd_ps);
tiles!(wide512, "avx512f", 16, 4, __m512, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_set1_ps, _mm512_fmadd_ps);
