//! The widest vector instructions of the machine, for loops whose results do not depend on the width.
//!
//! A hot loop is written once, as plain array code marked `#[inline(always)]`, and compiled a second and third time with
//! AVX2 and AVX-512 switched on by [`wide`]. Nothing is contracted or reordered by that: multiplications and additions
//! stay apart and keep their order, so all copies give the same bits. Other machines run the plain copy.
//! `unsafe` lives here in one place: calling a function compiled for instructions that were found at run time.

/// Runs `work` compiled for the widest vectors that the machine has.
#[inline]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        cpufeatures::new!(has_avx512, "avx512f");
        cpufeatures::new!(has_avx2, "avx2");
        if has_avx512::get() {
            // SAFETY: the machine and its system support AVX-512F, as just found.
            return unsafe { with_avx512(work) };
        }
        if has_avx2::get() {
            // SAFETY: the machine and its system support AVX2, as just found.
            return unsafe { with_avx2(work) };
        }
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn with_avx512<R>(work: impl FnOnce() -> R) -> R {
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<R>(work: impl FnOnce() -> R) -> R {
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_loop_gives_the_bits_of_the_plain_one() {
        #[inline(always)]
        fn sums(a: &[f64; 37], b: &mut [f64; 37]) {
            for (x, y) in a.iter().zip(b.iter_mut()) {
                *y = (*y - 0.3 * x) + x * x;
            }
        }
        let a: [f64; 37] = core::array::from_fn(|i| crate::base::random::unit_f64(1, 2, i as u64));
        let (mut plain, mut vectors) = ([0.7; 37], [0.7; 37]);
        sums(&a, &mut plain);
        wide(|| sums(&a, &mut vectors));
        assert_eq!(plain.map(f64::to_bits), vectors.map(f64::to_bits));
    }
}
