//! The number type of a tape: f32 to train, f64 to check every derivative.

use super::plain;
use super::{Path, Rows};
use crate::base::real::Real;
use bytemuck::Pod;
use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// f32 or f64, with arithmetic and the rows of a matrix product.
pub trait Float:
    Real
    + Pod
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;

    /// The nearest value.
    fn of(x: f64) -> Self;

    /// The same value in f64.
    fn wide(self) -> f64;

    /// Total order: by `total_cmp`.
    fn order(self, other: Self) -> Ordering;

    /// Columns of a packed panel of B.
    fn panel(path: Path) -> usize;

    /// Does the task of a product.
    fn fill_rows(path: Path, task: Rows<Self>);
}

impl Float for f32 {
    const ZERO: f32 = 0.0;
    const ONE: f32 = 1.0;

    #[inline(always)]
    fn order(self, other: f32) -> Ordering {
        self.total_cmp(&other)
    }

    #[inline(always)]
    fn of(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self as f64
    }

    fn panel(path: Path) -> usize {
        match path {
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 | Path::Avx512 => super::x86::panel(path),
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Path::Neon => super::neon::WIDTH,
            _ => plain::WIDTH,
        }
    }

    fn fill_rows(path: Path, task: Rows<f32>) {
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
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;

    #[inline(always)]
    fn order(self, other: f64) -> Ordering {
        self.total_cmp(&other)
    }

    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }

    fn panel(_: Path) -> usize {
        plain::WIDTH
    }

    fn fill_rows(_: Path, task: Rows<f64>) {
        plain::fill_rows(task, |a, b, c| a * b + c);
    }
}
