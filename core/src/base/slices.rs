//! Parts of slices, taken without a panic path: what the standard library asserts about lengths holds here by itself.
//!
//! A length of our own that is wrong is met by the next index into the part, or by a check in debug builds.

use core::mem::take;

/// Rows, runs and copies of a slice.
pub trait Slices<T> {
    /// Writes `from`, which is as long.
    fn copy_from(&mut self, from: &[T])
    where
        T: Copy;

    /// The rows of an array (rows, width), one after the other; a row that is not whole is left out, as are all of width 0.
    fn rows(&self, width: usize) -> Rows<'_, T>;

    /// [`rows`](Self::rows), to be written.
    fn rows_mut(&mut self, width: usize) -> RowsMut<'_, T>;

    /// The first `at` items and the others, of which there are as many at the least.
    fn parted_mut(&mut self, at: usize) -> (&mut [T], &mut [T]);

    /// Runs of neighbours that are pairwise the `same`; they cover the slice.
    fn runs<F: FnMut(&T, &T) -> bool>(&self, same: F) -> Runs<'_, T, F>;
}

impl<T> Slices<T> for [T] {
    #[inline]
    fn copy_from(&mut self, from: &[T])
    where
        T: Copy,
    {
        debug_assert_eq!(self.len(), from.len(), "a copy is as long as what it is of");
        self[..from.len()].iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }

    #[inline]
    fn rows(&self, width: usize) -> Rows<'_, T> {
        Rows { rest: if width > 0 { self } else { &[] }, width: width.max(1) }
    }

    #[inline]
    fn rows_mut(&mut self, width: usize) -> RowsMut<'_, T> {
        RowsMut { rest: if width > 0 { self } else { &mut [] }, width: width.max(1) }
    }

    #[inline]
    fn parted_mut(&mut self, at: usize) -> (&mut [T], &mut [T]) {
        debug_assert!(at <= self.len(), "{at} of {} items", self.len());
        self.split_at_mut_checked(at).unwrap_or_default()
    }

    #[inline]
    fn runs<F: FnMut(&T, &T) -> bool>(&self, same: F) -> Runs<'_, T, F> {
        Runs { rest: self, same }
    }
}

/// See [`Slices::rows`].
#[derive(Clone)]
pub struct Rows<'a, T> {
    rest: &'a [T],
    width: usize, // not 0
}

impl<'a, T> Iterator for Rows<'a, T> {
    type Item = &'a [T];

    #[inline]
    fn next(&mut self) -> Option<&'a [T]> {
        let (row, rest) = self.rest.split_at_checked(self.width)?;
        self.rest = rest;
        Some(row)
    }
}

/// See [`Slices::rows_mut`].
pub struct RowsMut<'a, T> {
    rest: &'a mut [T],
    width: usize, // not 0
}

impl<'a, T> Iterator for RowsMut<'a, T> {
    type Item = &'a mut [T];

    #[inline]
    fn next(&mut self) -> Option<&'a mut [T]> {
        if self.rest.len() < self.width {
            return None;
        }
        let (row, rest) = take(&mut self.rest).split_at_mut_checked(self.width)?;
        self.rest = rest;
        Some(row)
    }
}

impl<'a, T> RowsMut<'a, T> {
    /// What no row has been made of.
    pub fn into_rest(self) -> &'a mut [T] {
        self.rest
    }
}

/// See [`Slices::runs`].
#[derive(Clone)]
pub struct Runs<'a, T, F> {
    rest: &'a [T],
    same: F,
}

impl<'a, T, F: FnMut(&T, &T) -> bool> Iterator for Runs<'a, T, F> {
    type Item = &'a [T];

    #[inline]
    fn next(&mut self) -> Option<&'a [T]> {
        let pairs = self.rest.iter().zip(self.rest.iter().skip(1));
        let len = 1 + pairs.take_while(|(a, b)| (self.same)(a, b)).count();
        // Where nothing is left, one is too many.
        let (run, rest) = self.rest.split_at_checked(len)?;
        self.rest = rest;
        Some(run)
    }
}

/// Splits the first `count` items off.
#[inline]
pub fn take_first<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, behind) = take(rest).parted_mut(count);
    *rest = behind;
    &mut first[..count]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn rows_are_whole_and_runs_cover_the_slice() {
        let mut items = [1, 1, 2, 3, 3, 3, 1];
        assert_eq!(items.rows(3).collect::<Vec<_>>(), [[1, 1, 2], [3, 3, 3]]);
        assert_eq!(items.rows_mut(4).count(), 1);
        assert_eq!(items.runs(|a, b| a == b).collect::<Vec<_>>(), [&[1, 1][..], &[2], &[3, 3, 3], &[1]]);
        assert_eq!(items.runs(|_, _| true).count(), 1);
    }

    #[test]
    fn nothing_has_no_rows_and_no_runs() {
        assert_eq!(([0; 5].rows(0).count(), [0; 5].rows_mut(0).count(), [0; 2].rows(3).count()), (0, 0, 0));
        assert_eq!([0; 0].runs(|_, _| true).count(), 0);
    }
}
