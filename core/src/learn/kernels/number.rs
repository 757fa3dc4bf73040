//! Arithmetic of the two number types: f32 to train, f64 to check every derivative.

use crate::base::real::Real;
use bytemuck::Pod;
use core::cmp::Ordering;
use core::ops;

/// f32 or f64, with arithmetic.
pub trait Number:
    Real
    + Pod
    + Send
    + Sync
    + ops::Add<Output = Self>
    + ops::Sub<Output = Self>
    + ops::Mul<Output = Self>
    + ops::Div<Output = Self>
    + ops::Neg<Output = Self>
    + ops::AddAssign
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
}

impl Number for f32 {
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
}

impl Number for f64 {
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
}
