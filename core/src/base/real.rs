//! Square roots, rounding and transcendental functions from libm, on every target.
//!
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

macro_rules! real {
    ($type:ty, $sqrt:ident, $floor:ident, $ceil:ident, $round:ident, $exp:ident, $ln:ident, $sin:ident, $cos:ident,
     $acos:ident, $atan2:ident, $pow:ident) => {
        impl Real for $type {
            #[inline(always)]
            fn map(self, function: Function) -> Self {
                match function {
                    Function::Sqrt => libm::$sqrt(self),
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

real!(f32, sqrtf, floorf, ceilf, roundf, expf, logf, sinf, cosf, acosf, atan2f, powf);
real!(f64, sqrt, floor, ceil, round, exp, log, sin, cos, acos, atan2, pow);

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

/// Bits of a decision: 12 let mirror images tie that Newton's method has left 1e-5 apart and blur a near choice by 0.02 %;
/// with 20, a mesh that was written with 9 digits decides otherwise than one with 17.
const DECISION_BITS: u32 = 12;
/// Bits of a cost or length that is summed along paths: 16 leave 37 bits, so that sums of what lies within a factor of
/// 2^37 are exact and ties are ties.
const COST_BITS: u32 = 16;

/// `x` to 12 bits: what an arg-max compares, so that rounding that differs from one placing of a mesh to another does not
/// decide. Infinities and NaN stay.
#[inline]
pub fn for_decision(x: f64) -> f64 {
    to_bits(x, DECISION_BITS)
}

/// `x` to 16 bits, see [`for_decision`]: what is summed along a path.
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
