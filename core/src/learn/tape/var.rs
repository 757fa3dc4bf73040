//! Values and tables of a tape: where each lies in the slices of a replay.

use crate::base::slices::Slices;
use core::ops::Range;

/// Entry of a table that names no row: a missing neighbour.
pub const NONE: u32 = u32::MAX;

/// A matrix of values, row after row, and its gradient at the same place of the other slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Var {
    pub(super) id: u16,
    pub(super) has_gradient: bool,
    pub(super) at: usize,
    /// Rows, one a point.
    pub rows: usize,
    /// Values of a row.
    pub columns: usize,
}

impl Var {
    /// Number of values.
    pub fn count(self) -> usize {
        self.rows * self.columns
    }

    /// Where its values lie in the slice of values or gradients.
    pub fn range(self) -> Range<usize> {
        self.at..self.at + self.count()
    }

    /// Its part of `slice`.
    pub fn of<T>(self, slice: &[T]) -> &[T] {
        &slice[self.range()]
    }

    /// Its part of `slice`, to be written.
    pub fn of_mut<T>(self, slice: &mut [T]) -> &mut [T] {
        &mut slice[self.range()]
    }

    /// All that lies before it, and its own part, to be written.
    pub(super) fn split<T>(self, slice: &mut [T]) -> (&mut [T], &mut [T]) {
        let (before, rest) = slice.parted_mut(self.at);
        (before, &mut rest[..self.count()])
    }
}

/// A stretch of the slice of indices: faces, neighbours, or what forward found out for backward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table {
    pub(super) at: usize,
    pub(super) len: usize,
}

impl Table {
    /// Its part of the indices.
    pub fn of(self, indices: &[u32]) -> &[u32] {
        &indices[self.at..self.at + self.len]
    }

    /// Its part of the indices, to be written.
    pub fn of_mut(self, indices: &mut [u32]) -> &mut [u32] {
        &mut indices[self.at..self.at + self.len]
    }
}
