//! Square roots, rounding and transcendental functions from libm, on every target.
//!
//! Square roots are rounded right everywhere, so those of x86-64 are taken there, as instructions that the compiler knows: libm's, into
//! which it cannot see, costs some fifty others where it stands between those of wide vectors. `unsafe` lives here for them alone.
//! Free functions over [`Real`], so that no inherent method of a linked `std` can take their place.

/// f32 or f64.
pub trait Real: Copy + PartialOrd {
    /// See the free functions of this module.
    fn map(self, function: Function) -> Self;
    /// See [`atan2`].
    fn atan2_of(self, x: Self) -> Self;
    /// See [`pow`].
    fn pow_of(self, exponent: Self) -> Self;
}

/// A function of one argument.
#[derive(Clone, Copy)]
#[allow(missing_docs)]
pub enum Function {
    Sqrt,
    Floor,
    Ceil,
    Round,
    Exp,
    Ln,
    Sin,
    Cos,
    Acos,
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod roots {
    use core::arch::x86_64::*;

    #[inline(always)]
    pub fn root_f32(x: f32) -> f32 {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }

    #[inline(always)]
    pub fn root_f64(x: f64) -> f64 {
        // SAFETY: SSE2 is part of x86-64.
        unsafe { _mm_cvtsd_f64(_mm_sqrt_sd(_mm_set_sd(x), _mm_set_sd(x))) }
    }
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
mod roots {
    pub use libm::{sqrt as root_f64, sqrtf as root_f32};
}

use roots::{root_f32, root_f64};

macro_rules! real {
    ($type:ty, $sqrt:ident, $floor:ident, $ceil:ident, $round:ident, $exp:ident, $ln:ident, $sin:ident, $cos:ident,
     $acos:ident, $atan2:ident, $pow:ident) => {
        impl Real for $type {
            #[inline(always)]
            fn map(self, function: Function) -> Self {
                match function {
                    Function::Sqrt => $sqrt(self),
                    Function::Floor => libm::$floor(self),
                    Function::Ceil => libm::$ceil(self),
                    Function::Round => libm::$round(self),
                    Function::Exp => libm::$exp(self),
                    Function::Ln => libm::$ln(self),
                    Function::Sin => libm::$sin(self),
                    Function::Cos => libm::$cos(self),
                    Function::Acos => libm::$acos(self),
                }
            }
            #[inline(always)]
            fn atan2_of(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            #[inline(always)]
            fn pow_of(self, exponent: Self) -> Self {
                libm::$pow(self, exponent)
            }
        }
    };
}

real!(f32, root_f32, floorf, ceilf, roundf, expf, logf, sinf, cosf, acosf, atan2f, powf);
real!(f64, root_f64, floor, ceil, round, exp, log, sin, cos, acos, atan2, pow);

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident => $variant:ident;)*) => {
        $($(#[$doc])*
        #[inline(always)]
        pub fn $name<T: Real>(x: T) -> T {
            x.map(Function::$variant)
        })*
    };
}

functions! {
    /// Square root; NaN below zero.
    sqrt => Sqrt;
    /// Largest integer not above x.
    floor => Floor;
    /// Smallest integer not below x.
    ceil => Ceil;
    /// Nearest integer, halves away from zero.
    round => Round;
    /// e^x.
    exp => Exp;
    /// Natural logarithm.
    ln => Ln;
    /// Sine of radians.
    sin => Sin;
    /// Cosine of radians.
    cos => Cos;
    /// Arc cosine in radians; NaN outside [-1, 1].
    acos => Acos;
}

/// Bits of a decision. What Newton's method leaves differs by 1e-6 where a mesh is written with 9 digits instead of 17, so
/// that with 12 bits one in 250 mirror images does not tie; 6 blur a choice by a percent.
const DECISION_BITS: u32 = 8;
/// Bits of a cost or length that is summed along paths; sums of such numbers are exact, and ties are ties. With 16, some
/// edges of a mesh of 9,000 round otherwise when it is written with 9 digits, and cow gets two charts more; with 10, one
/// edge in two meshes.
const COST_BITS: u32 = 10;

/// `x` to 0.2 %: what an arg-max compares, so that rounding that differs from one placing of a mesh to another does not
/// decide. Infinities and NaN stay.
#[inline]
pub fn for_decision(x: f64) -> f64 {
    to_bits(x, DECISION_BITS)
}

/// `x` to 0.05 %, see [`for_decision`]: what is summed along a path.
#[inline]
pub fn for_cost(x: f64) -> f64 {
    to_bits(x, COST_BITS)
}

/// `x` rounded to `bits` bits after the leading one, halves away from zero.
fn to_bits(x: f64, bits: u32) -> f64 {
    let dropped = f64::MANTISSA_DIGITS - 1 - bits;
    if x.is_finite() { f64::from_bits((x.to_bits() + (1 << (dropped - 1))) & !((1 << dropped) - 1)) } else { x }
}

/// Angle of (x, y) in (-pi, pi].
#[inline(always)]
pub fn atan2<T: Real>(y: T, x: T) -> T {
    y.atan2_of(x)
}

/// base^exponent.
#[inline(always)]
pub fn pow<T: Real>(base: T, exponent: T) -> T {
    base.pow_of(exponent)
}

#[cfg(test)]
mod tests {
    use super::super::random::hash;
    use super::*;

    #[test]
    fn square_roots_are_those_of_libm() {
        for i in 0..100_000 {
            let (x, y) = (f64::from_bits(hash(1, 2, i)), f32::from_bits(hash(3, 4, i) as u32));
            assert_eq!(sqrt(x).to_bits(), libm::sqrt(x).to_bits(), "{x}");
            assert_eq!(sqrt(y).to_bits(), libm::sqrtf(y).to_bits(), "{y}");
        }
    }
}
