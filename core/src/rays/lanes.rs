//! Eight f32 at a time, in plain arrays or SSE registers; one meaning, so one result, on both.
//!
//! Every operation is a single IEEE operation a lane (no fused multiply-add, no reciprocal estimates), and `min` and
//! `max` are `bvh::min` and `bvh::max`, NaN included. The registers are worth their file:
//! with plain arrays exposure on spot takes 1.25 times as long.
//! `unsafe` lives here: calls of SSE intrinsics, which every x86-64 has.
#![allow(unsafe_code)]

#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
use super::bvh;

/// Lanes of a vector. 4 takes 1.25 and 16 takes 1.1 times as long on nefertiti.
pub(super) const LANES: usize = 8;

/// Eight f32.
pub(super) trait Lanes: Copy {
    /// Reads an array.
    fn load(from: &[f32; LANES]) -> Self;
    /// The same value in each lane.
    fn splat(x: f32) -> Self;
    /// self - other.
    fn sub(self, other: Self) -> Self;
    /// self * other.
    fn mul(self, other: Self) -> Self;
    /// The lesser; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The greater; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// Bit i: lane i of self <= that of other.
    fn le(self, other: Self) -> u32;
}

/// Plain arrays: the meaning of the other.
#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
#[derive(Clone, Copy)]
pub(super) struct Plain([f32; LANES]);

#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self;
        for i in 0..out.0.len() {
            out.0[i] = f(self.0[i], other.0[i]);
        }
        out
    }
}

#[cfg(any(test, not(all(target_arch = "x86_64", target_feature = "sse2"))))]
impl Lanes for Plain {
    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, bvh::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, bvh::max)
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        (0..LANES).fold(0, |bits, i| bits | ((self.0[i] <= other.0[i]) as u32) << i)
    }
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(super) use x86::Sse as Widest;

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(super) use Plain as Widest;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod x86 {
    use super::{LANES, Lanes};
    use core::arch::x86_64::*;

    /// Two SSE registers.
    #[derive(Clone, Copy)]
    pub struct Sse([__m128; LANES / 4]);

    impl Sse {
        #[inline(always)]
        fn zip(self, other: Self, f: impl Fn(__m128, __m128) -> __m128) -> Self {
            let mut out = self;
            for i in 0..out.0.len() {
                out.0[i] = f(self.0[i], other.0[i]);
            }
            out
        }
    }

    // SAFETY of every block: SSE2 is enabled for the whole target (see the `cfg`); reads stay in the array.
    impl Lanes for Sse {
        #[inline(always)]
        fn load(from: &[f32; LANES]) -> Self {
            let mut out = Self::splat(0.0);
            for (i, out) in out.0.iter_mut().enumerate() {
                *out = unsafe { _mm_loadu_ps(from.as_ptr().add(4 * i)) };
            }
            out
        }
        #[inline(always)]
        fn splat(x: f32) -> Self {
            Self([unsafe { _mm_set1_ps(x) }; LANES / 4])
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm_sub_ps(a, b) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm_mul_ps(a, b) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm_min_ps(a, b) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm_max_ps(a, b) })
        }
        #[inline(always)]
        fn le(self, other: Self) -> u32 {
            let mut bits = 0;
            for i in 0..LANES / 4 {
                bits |= (unsafe { _mm_movemask_ps(_mm_cmple_ps(self.0[i], other.0[i])) } as u32) << (4 * i);
            }
            bits
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_agree_on_every_pair_of_special_values() {
        let values = [0.0, -0.0, 1.5, -2.25, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-42];
        for shift in 0..LANES {
            let a = values;
            let b: [f32; LANES] = core::array::from_fn(|i| values[(i + shift) % LANES]);
            fn masks<L: Lanes>(a: &[f32; LANES], b: &[f32; LANES]) -> [u32; 7] {
                let (a, b, zero) = (L::load(a), L::load(b), L::splat(0.0));
                let results = [a.sub(b), a.mul(b), a.min(b), a.max(b)];
                [
                    a.le(b),
                    b.le(a),
                    a.le(zero),
                    results[0].le(zero),
                    results[1].le(b),
                    results[2].le(b),
                    results[3].le(a),
                ]
            }
            assert_eq!(masks::<Plain>(&a, &b), masks::<Widest>(&a, &b));
        }
    }
}
