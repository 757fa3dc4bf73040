//! What a task of a product is given: rows of C and A, and B in panels.

use super::number::Number;

/// Depth of a slab: a panel of B of 16 columns takes 16 KB of the first cache. 128 and 512 were within 3 %.
pub(super) const SLAB: usize = 256;
/// Rows of A that a task packs at a time, on its stack: 24 x 256 values = 24 KB. 66 was slower for small products.
#[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), allow(dead_code))]
pub(super) const PACKED_ROWS: usize = 24;

/// A matrix in a slice: element (i, j) is `data[i * row + j * column]`.
#[derive(Clone, Copy)]
pub struct Matrix<'a, T> {
    pub(super) data: &'a [T],
    pub(super) row: usize,
    pub(super) column: usize,
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

/// What a task of [`super::product::product`] does: adds A B to some rows of C.
pub struct RowTask<'r, T> {
    /// The rows: a multiple of `columns` values.
    pub(super) rows: &'r mut [T],
    pub(super) columns: usize,
    pub(super) depth: usize,
    /// A from the first of these rows on.
    pub(super) a: Matrix<'r, T>,
    /// All of B in panels.
    pub(super) packed: &'r [T],
    /// Whether the sums begin at zero, whatever stands in the rows.
    pub(super) begins_at_zero: bool,
}

/// `columns`, made up to whole panels of `width`: a power of two.
#[inline(always)]
pub(super) const fn padded(columns: usize, width: usize) -> usize {
    (columns + width - 1) & !(width - 1)
}

/// Where the panel that begins at `column` lies in packed B: slab after slab, in each panel after panel.
#[inline(always)]
pub(super) fn panel_of(
    slab: &core::ops::Range<usize>,
    column: usize,
    columns: usize,
    width: usize,
) -> core::ops::Range<usize> {
    let at = slab.start * padded(columns, width) + column * slab.len();
    at..at + width * slab.len()
}

/// Rows `row..end` of A (up to `HEIGHT`), depth `slab`, one step of the depth after the other, with its place in
/// the slab; rows that are missing are zero.
#[inline(always)]
pub(super) fn steps<T: Number, const HEIGHT: usize>(
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
