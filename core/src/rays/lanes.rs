//! Eight f32 at a time, in plain arrays, SSE2 or AVX; one meaning, so one result, on all of them.
//!
//! Every operation is a single IEEE operation a lane (no fused multiply-add, no reciprocal estimates), and `min` and
//! `max` are `bvh::min` and `bvh::max`, NaN included.
//! `unsafe` lives here: calls of intrinsics. SSE2 is part of the x86-64 baseline, and [`Avx`] values only exist inside
//! functions that [`widest`] allowed.
#![allow(unsafe_code)]

use super::bvh;

/// Lanes of a vector.
pub const LANES: usize = 8;

/// Which kind of lanes a machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// What every machine of the target has.
    Baseline,
    /// x86-64 with AVX.
    Avx,
}

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

/// Plain arrays: the meaning of the others.
#[derive(Clone, Copy)]
pub(super) struct Plain([f32; LANES]);

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
pub(super) use x86::{Avx, Sse as Baseline};

#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(super) use Plain as Baseline;

/// The widest lanes of this machine. Asks the processor: call once a scene, not once a ray.
pub fn widest() -> Width {
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    if x86::has_avx() {
        return Width::Avx;
    }
    Width::Baseline
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod x86 {
    use super::{LANES, Lanes};
    use core::arch::x86_64::*;

    /// SSE registers.
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

    // SAFETY of every block: SSE2 is enabled for the whole target (see the `cfg`); pointers are to arrays of 8.
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

    /// AVX registers.
    #[derive(Clone, Copy)]
    pub struct Avx([__m256; LANES / 8]);

    impl Avx {
        #[inline(always)]
        fn zip(self, other: Self, f: impl Fn(__m256, __m256) -> __m256) -> Self {
            let mut out = self;
            for i in 0..out.0.len() {
                out.0[i] = f(self.0[i], other.0[i]);
            }
            out
        }
    }

    // SAFETY of every block: only reached from the caller of `widest`, which has seen AVX; pointers are to arrays of 8.
    impl Lanes for Avx {
        #[inline(always)]
        fn load(from: &[f32; LANES]) -> Self {
            let mut out = Self::splat(0.0);
            for (i, out) in out.0.iter_mut().enumerate() {
                *out = unsafe { _mm256_loadu_ps(from.as_ptr().add(8 * i)) };
            }
            out
        }
        #[inline(always)]
        fn splat(x: f32) -> Self {
            Self([unsafe { _mm256_set1_ps(x) }; LANES / 8])
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm256_sub_ps(a, b) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm256_mul_ps(a, b) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm256_min_ps(a, b) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            self.zip(other, |a, b| unsafe { _mm256_max_ps(a, b) })
        }
        #[inline(always)]
        fn le(self, other: Self) -> u32 {
            let mut bits = 0;
            for i in 0..LANES / 8 {
                bits |= (unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0[i], other.0[i])) } as u32)
                    << (8 * i);
            }
            bits
        }
    }

    /// AVX in the processor and its registers saved by the operating system.
    pub fn has_avx() -> bool {
        const OSXSAVE_AND_AVX: u32 = 1 << 27 | 1 << 28;
        #[target_feature(enable = "xsave")]
        fn saved() -> u64 {
            // SAFETY: the caller has seen OSXSAVE.
            unsafe { _xgetbv(0) }
        }
        // SAFETY: every x86-64 has CPUID leaf 1.
        #[allow(unused_unsafe)]
        let features = unsafe { __cpuid(1) }.ecx;
        // SAFETY: OSXSAVE is the right to execute XGETBV.
        features & OSXSAVE_AND_AVX == OSXSAVE_AND_AVX && unsafe { saved() } & 6 == 6
    }
}
