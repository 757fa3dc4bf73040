//! Eight f32 side by side, for loops that compilers do not find a way to vectorise by themselves.
//!
//! A hot loop is written once over [`Eight`] as a [`EightTask`], and [`widest`] runs it with AVX2 where the machine has it, with plain
//! arrays elsewhere. Every operation rounds as IEEE 754 says, one by one, so both give the same bits; nothing is contracted.
//! `unsafe` lives here for the instructions of AVX2 alone: the type that calls them is made by [`widest`], which has asked the machine.

/// Numbers of one register.
pub const COUNT: usize = 8;

/// Operations on eight numbers at once.
pub trait Eight: Copy {
    /// The same number eight times.
    fn all(x: f32) -> Self;
    /// These numbers.
    fn of(x: &[f32; COUNT]) -> Self;
    /// As an array.
    fn array(self) -> [f32; COUNT];
    /// Sums.
    fn plus(self, other: Self) -> Self;
    /// Differences.
    fn less(self, other: Self) -> Self;
    /// Products.
    fn times(self, other: Self) -> Self;
    /// Quotients.
    fn over(self, other: Self) -> Self;
    /// The larger ones; those of `other` where either is not a number.
    fn max(self, other: Self) -> Self;
    /// The smaller ones; those of `other` where either is not a number.
    fn min(self, other: Self) -> Self;
    /// Without signs.
    fn abs(self) -> Self;
    /// Those that are larger than 0, and `other` where they are not.
    fn positive_or(self, other: Self) -> Self;
    /// A bit for each that is smaller than that of `other`, the first lowest.
    fn below(self, other: Self) -> u32;
    /// Without what stands behind the point, and `first + row * width + whole` of `self` and the whole parts of `row`: what both are
    /// must be in 0..2^31.
    fn cells(self, row: Self, first: u32, width: u32) -> ([Self; 2], [u32; COUNT]);
    /// First numbers of the eight rows, second numbers, and so on.
    fn columns(rows: [[f32; 4]; COUNT]) -> [Self; 4];
}

/// What is done over eight numbers at once, and with what result.
pub trait EightTask<R> {
    /// Does it; marked `#[inline(always)]`, as are all functions over [`Eight`] that it calls: closures are not, and what they hold is called
    /// one instruction at a time.
    fn run<E: Eight>(self) -> R;
}

/// Runs a task with the widest instructions of the machine.
#[inline]
pub fn widest<R>(task: impl EightTask<R>) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        cpufeatures::new!(has_avx2, "avx2");
        if has_avx2::get() {
            // SAFETY: the machine and its system support AVX2, as just found.
            return unsafe { avx2::run(task) };
        }
    }
    task.run::<PlainEight>()
}

/// Eight numbers in an array.
#[derive(Clone, Copy)]
struct PlainEight([f32; COUNT]);

impl PlainEight {
    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(core::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl Eight for PlainEight {
    #[inline(always)]
    fn all(x: f32) -> Self {
        Self([x; COUNT])
    }
    #[inline(always)]
    fn of(x: &[f32; COUNT]) -> Self {
        Self(*x)
    }
    #[inline(always)]
    fn array(self) -> [f32; COUNT] {
        self.0
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self.with(other, |a, b| a / b)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.with(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.with(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn positive_or(self, other: Self) -> Self {
        self.with(other, |a, b| if a > 0.0 { a } else { b })
    }
    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        (0..COUNT).fold(0, |bits, i| bits | u32::from(self.0[i] < other.0[i]) << i)
    }
    #[inline(always)]
    fn cells(self, row: Self, first: u32, width: u32) -> ([Self; 2], [u32; COUNT]) {
        let (x, y) = (self.0.map(|x| x as u32), row.0.map(|y| y as u32));
        let at = |i: usize| first.wrapping_add(y[i].wrapping_mul(width)).wrapping_add(x[i]);
        ([Self(x.map(|x| x as f32)), Self(y.map(|y| y as f32))], core::array::from_fn(at))
    }
    #[inline(always)]
    fn columns(rows: [[f32; 4]; COUNT]) -> [Self; 4] {
        core::array::from_fn(|column| Self(rows.map(|row| row[column])))
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{COUNT, Eight, EightTask};
    use core::arch::x86_64::*;

    /// Runs a task with AVX2, which the machine must have.
    #[target_feature(enable = "avx2")]
    pub fn run<R>(task: impl EightTask<R>) -> R {
        task.run::<Avx2>()
    }

    /// Eight numbers in a register. SAFETY, of every block below: no other module can name this type, and [`run`] alone hands it to a
    /// task, where the machine has AVX2; pointers are those of arrays of eight.
    #[derive(Clone, Copy)]
    struct Avx2(__m256);

    /// Rows `i` and `i + 4`.
    #[inline(always)]
    fn pair(rows: &[[f32; 4]; COUNT], i: usize) -> __m256 {
        unsafe {
            let (low, high) = (_mm_loadu_ps(rows[i].as_ptr()), _mm_loadu_ps(rows[i + 4].as_ptr()));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
        }
    }

    impl Eight for Avx2 {
        #[inline(always)]
        fn all(x: f32) -> Self {
            Self(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn of(x: &[f32; COUNT]) -> Self {
            Self(unsafe { _mm256_loadu_ps(x.as_ptr()) })
        }
        #[inline(always)]
        fn array(self) -> [f32; COUNT] {
            let mut to = [0.0; COUNT];
            unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) };
            to
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn less(self, other: Self) -> Self {
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn times(self, other: Self) -> Self {
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn over(self, other: Self) -> Self {
            Self(unsafe { _mm256_div_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }
        #[inline(always)]
        fn positive_or(self, other: Self) -> Self {
            Self(unsafe {
                let positive = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, _mm256_setzero_ps());
                _mm256_blendv_ps(other.0, self.0, positive)
            })
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn cells(self, row: Self, first: u32, width: u32) -> ([Self; 2], [u32; COUNT]) {
            let mut at = [0; COUNT];
            unsafe {
                let (x, y) = (_mm256_cvttps_epi32(self.0), _mm256_cvttps_epi32(row.0));
                let rows = _mm256_mullo_epi32(y, _mm256_set1_epi32(width as i32));
                let cells = _mm256_add_epi32(_mm256_add_epi32(_mm256_set1_epi32(first as i32), rows), x);
                _mm256_storeu_si256(at.as_mut_ptr().cast(), cells);
                ([Self(_mm256_cvtepi32_ps(x)), Self(_mm256_cvtepi32_ps(y))], at)
            }
        }
        #[inline(always)]
        fn columns(rows: [[f32; 4]; COUNT]) -> [Self; 4] {
            unsafe {
                let (a, b, c, d) = (pair(&rows, 0), pair(&rows, 1), pair(&rows, 2), pair(&rows, 3));
                let (ab, ab_high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
                let (cd, cd_high) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
                [
                    Self(_mm256_shuffle_ps::<0x44>(ab, cd)),
                    Self(_mm256_shuffle_ps::<0xee>(ab, cd)),
                    Self(_mm256_shuffle_ps::<0x44>(ab_high, cd_high)),
                    Self(_mm256_shuffle_ps::<0xee>(ab_high, cd_high)),
                ]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random;

    /// Each operation once, one after the other.
    struct Everything([[f32; COUNT]; 3]);

    impl EightTask<([[u32; COUNT]; 17], u32)> for Everything {
        #[inline(always)]
        fn run<E: Eight>(self) -> ([[u32; COUNT]; 17], u32) {
            let [a, b, c] = self.0.map(|x| E::of(&x));
            let (sum, difference, product) = (a.plus(b), a.less(b), a.times(b));
            let (quotient, larger, smaller) = (a.over(b), a.max(b), b.min(c));
            let zero = a.less(a).over(a.less(a)).max(E::all(0.0));
            let (positive, plain) = (difference.positive_or(c), difference.abs());
            let (x, y) = (plain.times(E::all(100.0)), c.abs().times(E::all(100.0)));
            let ([column, row], at) = x.cells(y, 7, 300);
            let rows = core::array::from_fn(|i| {
                let [a, b, c] = self.0;
                [a[i], b[i], c[i], a[i] - b[i]]
            });
            let [p, q, r, s] = E::columns(rows);
            let all = [
                sum, difference, product, quotient, larger, smaller, positive, plain, column, row, p, q, r, s, zero, x,
            ];
            let mut bits = [at; 17];
            bits.iter_mut().zip(all).for_each(|(to, e)| *to = e.array().map(f32::to_bits));
            (bits, difference.below(c))
        }
    }

    #[test]
    fn the_widest_instructions_give_the_bits_of_plain_arrays() {
        for case in 0..2000 {
            let draw = |i: usize| random::unit_f64(case, 5, i as u64) as f32 * 4.0 - 2.0;
            let mut numbers: [[f32; COUNT]; 3] = core::array::from_fn(|k| core::array::from_fn(|i| draw(8 * k + i)));
            if case % 3 == 0 {
                (numbers[0][3], numbers[1][3], numbers[2][5]) = (0.0, -0.0, 0.0);
            }
            assert_eq!(widest(Everything(numbers)), Everything(numbers).run::<PlainEight>(), "case {case}");
        }
    }
}
