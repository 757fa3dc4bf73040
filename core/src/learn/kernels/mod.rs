//! Matrix products for affine layers: C = start + A B, each element summed over the depth in order.
//!
//! B is packed into panels of a few columns; tasks own blocks of C's rows, walk the depth in slabs and keep a tile of C
//! in registers (Goto, van de Geijn, *Anatomy of high-performance matrix multiplication*, 2008). A tile takes C up
//! again where the slab before left it, so blocking never changes the order of a sum.
//! Guaranteed for f32: every path, tile shape and number of threads gives the same bits, because each step is one fused
//! multiply-add, rounded once ([`fused`] computes it exactly where the machine has none).
//! f64 has the plain path alone, multiply then add: it is there to check the derivatives, not to be fast.
//! A path for another machine is a [`Path`], a panel width and a function that fills rows (see [`tiles`]).

#[macro_use]
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
mod tiles;

pub mod float;
pub mod fused;
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod neon;
mod plain;
mod product_tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use core::num::NonZero;
pub use float::Float;

/// Slope of LeakyReLU below zero.
pub const SLOPE: f64 = 0.01;
/// Depth of a slab: a panel of B of 16 columns takes 16 KB of the first cache. 128 and 512 were within 3 %.
const SLAB: usize = 256;
/// Rows of A that a task packs at a time, on its stack: 24 x 256 values = 24 KB. 66 was slower for small products.
#[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), allow(dead_code))]
const PACKED_ROWS: usize = 24;
/// Rows of a task at the most, so that those of A stay in the second cache. 24 and 132 were within the noise.
const ROWS: usize = 66;
/// Widest panel of any path, for sizes of memory.
const WIDEST: usize = 64;
/// Products with fewer multiplications than this are one task: handing out costs more (10 to 20 us).
const WORTH_SHARING: usize = 1 << 19;

/// How the f32 products are computed; all give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Array code with a fused multiply-add in software.
    Plain,
    /// AVX2 and FMA: tiles of 6 x 16.
    Avx2,
    /// AVX-512F: tiles of 6 x 64.
    Avx512,
    /// NEON of aarch64: tiles of 6 x 16.
    Neon,
}

impl Path {
    /// Every path, plain first.
    pub const ALL: [Path; 4] = [Path::Plain, Path::Avx2, Path::Avx512, Path::Neon];

    /// Whether this machine can run it.
    pub fn is_available(self) -> bool {
        match self {
            Path::Plain => true,
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 | Path::Avx512 => x86::has(self),
            Path::Neon => cfg!(all(target_arch = "aarch64", target_feature = "neon")),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The fastest path of this machine.
    pub fn best() -> Path {
        *Path::ALL.iter().rev().find(|path| path.is_available()).unwrap_or(&Path::Plain)
    }
}

/// A matrix in a slice: element (i, j) is `data[i * row + j * column]`.
#[derive(Clone, Copy)]
pub struct Matrix<'a, T> {
    data: &'a [T],
    row: usize,
    column: usize,
}

impl<'a, T> Matrix<'a, T> {
    /// Rows of `columns` values, one after the other.
    pub fn new(data: &'a [T], columns: usize) -> Self {
        Self { data, row: columns, column: 1 }
    }

    /// The same values with rows and columns exchanged.
    pub fn transposed(self) -> Self {
        Self { row: self.column, column: self.row, ..self }
    }
}

/// C is rows x columns, A rows x depth, B depth x columns.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Rows of C and A.
    pub rows: usize,
    /// Columns of C and B.
    pub columns: usize,
    /// Columns of A, rows of B: the length of each sum.
    pub depth: usize,
}

impl Shape {
    /// Values of memory that [`product`] packs B into.
    pub const fn packed(self) -> usize {
        self.columns.next_multiple_of(WIDEST).saturating_mul(self.depth)
    }

    /// Rows of a task: a multiple of every tile's height; fewer where C is low, so that two threads share it evenly.
    fn block(self) -> usize {
        if self.rows.saturating_mul(self.columns).saturating_mul(self.depth) < WORTH_SHARING {
            return self.rows;
        }
        (self.rows / if self.rows < 4 * ROWS { 5 } else { 8 }).next_multiple_of(6).clamp(12, ROWS)
    }
}

/// What each sum begins with.
#[derive(Clone, Copy)]
pub enum Start<'a, T> {
    /// Zero.
    Zero,
    /// The value that stands in C.
    Sum,
    /// One value a column.
    Bias(&'a [T]),
}

/// What happens to C's elements once they are summed.
#[derive(Clone, Copy)]
pub enum Finish<'a, T> {
    /// Nothing.
    Nothing,
    /// LeakyReLU.
    Leaky,
    /// Multiplication by LeakyReLU's slope at the same element of another layer's output (rows x columns; where it has
    /// fewer rows than C it is repeated).
    Masked(&'a [T]),
}

/// Slope of LeakyReLU where its output is `y`.
#[inline(always)]
pub fn slope_at<T: Float>(y: T) -> T {
    if y > T::ZERO { T::ONE } else { T::of(SLOPE) }
}

impl<T: Float> Finish<'_, T> {
    /// Applies it to rows `first..` of C.
    #[inline(always)]
    fn apply(self, rows: &mut [T], first: usize, columns: usize) {
        match self {
            Finish::Nothing => {}
            Finish::Leaky => rows.iter_mut().for_each(|y| *y = *y * slope_at(*y)),
            Finish::Masked(of) => {
                let Some(len) = NonZero::new(of.len()) else { return };
                for (i, row) in rows.rows_mut(columns).enumerate() {
                    let at = (first + i) * columns % len;
                    row.iter_mut().zip(&of[at..at + columns]).for_each(|(y, m)| *y = *y * slope_at(*m));
                }
            }
        }
    }
}

/// What a task of [`product`] does: adds A B to some rows of C.
pub struct Rows<'r, T> {
    /// The rows: a multiple of `columns` values.
    rows: &'r mut [T],
    columns: usize,
    depth: usize,
    /// A from the first of these rows on.
    a: Matrix<'r, T>,
    /// All of B in panels.
    packed: &'r [T],
    /// Whether the sums begin at zero, whatever stands in the rows.
    begins_at_zero: bool,
}

/// C = finish(start + A B). `packed` is memory of at least `shape.packed()` values. A slice that is too short for its
/// shape is a mistake of our own code and panics.
#[allow(clippy::too_many_arguments)]
pub fn product<T: Float>(
    c: &mut [T],
    shape: Shape,
    a: Matrix<T>,
    b: Matrix<T>,
    start: Start<T>,
    finish: Finish<T>,
    packed: &mut [T],
    path: Path,
    workers: &dyn Workers,
) {
    let Shape { rows, columns, depth } = shape;
    if rows == 0 || columns == 0 {
        return;
    }
    let path = if path.is_available() { path } else { Path::Plain };
    let width = T::panel(path);
    let padded = padded(columns, width);
    let packed = &mut packed[..padded * depth];
    if depth > 0 {
        for_each_chunk(workers, packed, SLAB * padded, &|slab, out| {
            let first = slab * SLAB;
            pack(out, b, first..(first + SLAB).min(depth), width, columns)
        });
    }
    let (packed, block) = (&*packed, shape.block());
    for_each_chunk(workers, &mut c[..rows * columns], block * columns, &|task, rows| {
        match start {
            Start::Zero if depth == 0 => rows.fill(T::ZERO),
            Start::Zero | Start::Sum => {}
            Start::Bias(bias) => rows.rows_mut(columns).for_each(|row| row.copy_from(bias)),
        }
        let first = task * block;
        let a = Matrix { data: &a.data[(first * a.row).min(a.data.len())..], ..a };
        let begins_at_zero = matches!(start, Start::Zero);
        T::fill_rows(path, Rows { rows, columns, depth, a, packed, begins_at_zero });
        finish.apply(rows, first, columns);
    });
}

/// `columns`, made up to whole panels of `width`: a power of two.
#[inline(always)]
const fn padded(columns: usize, width: usize) -> usize {
    (columns + width - 1) & !(width - 1)
}

/// Where the panel that begins at `column` lies in packed B: slab after slab, in each panel after panel.
#[inline(always)]
fn panel_of(slab: &core::ops::Range<usize>, column: usize, columns: usize, width: usize) -> core::ops::Range<usize> {
    let at = slab.start * padded(columns, width) + column * slab.len();
    at..at + width * slab.len()
}

/// Packs the rows `slab` of B; columns beyond the last become zero.
fn pack<T: Float>(out: &mut [T], b: Matrix<T>, slab: core::ops::Range<usize>, width: usize, columns: usize) {
    let (first, rows) = (slab.start, slab.len());
    if b.column == 1 {
        // Row by row, so that each is read once and in order.
        for k in 0..rows {
            let row = &b.data[(first + k) * b.row..][..columns];
            let mut column = 0;
            while column < columns {
                let (whole, rest) = row[column..columns.min(column + width)].as_chunks::<{ plain::WIDTH }>();
                let to = out[column * rows + k * width..][..width].as_chunks_mut::<{ plain::WIDTH }>().0;
                to.iter_mut().zip(whole).for_each(|(to, from)| *to = *from);
                column += width;
                if column > columns {
                    for (i, to) in to[whole.len()..].as_flattened_mut().iter_mut().enumerate() {
                        *to = rest.get(i).copied().unwrap_or(T::ZERO);
                    }
                }
            }
        }
    } else {
        // B is a transposed matrix: its columns are contiguous, and four are walked side by side.
        for (panel, out) in out.rows_mut(rows * width).enumerate() {
            for part in (0..width).step_by(4) {
                let column = panel * width + part;
                let line = |j: usize| &b.data[(column + j) * b.column + first..][..rows];
                if column + 4 <= columns {
                    let lines = line(0).iter().zip(line(1)).zip(line(2)).zip(line(3));
                    for (row, (((p, q), r), s)) in out.rows_mut(width).zip(lines) {
                        row[part..part + 4].copy_from(&[*p, *q, *r, *s]);
                    }
                } else {
                    for (k, row) in out.rows_mut(width).enumerate() {
                        for (j, to) in row[part..part + 4].iter_mut().enumerate() {
                            *to = if column + j < columns { line(j)[k] } else { T::ZERO };
                        }
                    }
                }
            }
        }
    }
}

/// Rows `row..end` of A (up to `HEIGHT`), depth `slab`, one step of the depth after the other, with its place in
/// the slab; rows that are missing are zero.
#[inline(always)]
fn steps<T: Float, const HEIGHT: usize>(
    a: Matrix<T>,
    row: usize,
    end: usize,
    slab: core::ops::Range<usize>,
    mut put: impl FnMut(usize, [T; HEIGHT]),
) {
    let there = end - row;
    if a.row == 1 && there == HEIGHT {
        for (i, k) in slab.enumerate() {
            let column = &a.data[row + k * a.column..][..HEIGHT];
            put(i, core::array::from_fn(|r| column[r]));
        }
        return;
    }
    for (i, k) in slab.enumerate() {
        put(i, core::array::from_fn(|r| if r < there { a.data[(row + r) * a.row + k * a.column] } else { T::ZERO }));
    }
}
