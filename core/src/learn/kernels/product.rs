//! Products of matrices, packed, blocked and handed out to workers.
//!
//! B is packed into panels of a few columns; tasks own blocks of C's rows, walk the depth in slabs and keep a tile of C
//! in registers (Goto, van de Geijn, *Anatomy of high-performance matrix multiplication*, 2008). A tile takes C up
//! again where the slab before left it, so blocking never changes the order of a sum.

use super::float::Float;
use super::path::Path;
use super::plain;
use super::task::{Matrix, RowTask, SLAB, padded};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use core::num::NonZero;

/// Slope of LeakyReLU below zero.
pub const SLOPE: f64 = 0.01;
/// Rows of a task at the most, so that those of A stay in the second cache. 24 and 132 were within the noise.
const ROWS: usize = 66;
/// Widest panel of any path, for sizes of memory.
const WIDEST: usize = 64;
/// Products with fewer multiplications than this are one task: handing out costs more (10 to 20 us).
const WORTH_SHARING: usize = 1 << 19;

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
        T::fill_rows(path, RowTask { rows, columns, depth, a, packed, begins_at_zero });
        finish.apply(rows, first, columns);
    });
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
