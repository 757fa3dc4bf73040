//! The number type of a tape: arithmetic, and how its products are computed.

use super::number::Number;
use super::path::Path;
use super::plain;
use super::task::RowTask;

/// f32 or f64, with arithmetic and the rows of a matrix product.
pub trait Float: Number {
    /// Columns of a packed panel of B.
    fn panel(path: Path) -> usize;

    /// Does the task of a product.
    fn fill_rows(path: Path, task: RowTask<Self>);
}

impl Float for f32 {
    fn panel(path: Path) -> usize {
        match path {
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 | Path::Avx512 => super::x86::panel(path),
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Path::Neon => super::neon::WIDTH,
            _ => plain::WIDTH,
        }
    }

    fn fill_rows(path: Path, task: RowTask<f32>) {
        match path {
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 | Path::Avx512 => super::x86::fill_rows(path, task),
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Path::Neon => super::neon::fill_rows(task),
            _ => plain::fill_rows(task, super::fused::fused),
        }
    }
}

impl Float for f64 {
    fn panel(_: Path) -> usize {
        plain::WIDTH
    }

    fn fill_rows(_: Path, task: RowTask<f64>) {
        plain::fill_rows(task, |a, b, c| a * b + c);
    }
}
