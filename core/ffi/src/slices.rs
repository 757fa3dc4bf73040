//! Slices out of pointers and counts, each checked before it is believed.
//!
//! `unsafe` lives here: reading what a caller's pointers point to. What cannot be checked is the caller's promise: that as
//! many values are there as it says, and that nobody else writes them during the call.

use crate::code::{Fault, SEAMWRIGHT_MISALIGNED, SEAMWRIGHT_NULL, SEAMWRIGHT_SHARED, SEAMWRIGHT_TOO_LARGE};
use core::mem::{align_of, size_of};
use core::ops::Range;
use core::slice;

/// Whether `at` may be dereferenced.
pub fn check<T>(at: *const T) -> Result<(), Fault> {
    match at {
        _ if at.is_null() => Err(Fault::new(SEAMWRIGHT_NULL)),
        _ if !at.is_aligned() => Err(Fault::new(SEAMWRIGHT_MISALIGNED)),
        _ => Ok(()),
    }
}

/// Buffers of one call, so that none that is written shares bytes with another.
#[derive(Default)]
pub struct Buffers {
    seen: [(Range<usize>, bool); MOST],
    count: usize,
}

/// Buffers of one call: eight of the mesh, three of the atlas, scratch; `measure` has fewer.
const MOST: usize = 12;

impl Buffers {
    /// `count` values of `T` to read.
    ///
    /// # Safety
    /// `count` values stand there, and are written by nobody for as long as the slice is used. `T` takes any bits.
    pub unsafe fn read<'a, T>(&mut self, start: *const T, count: usize) -> Result<&'a [T], Fault> {
        if self.claim(start, count, false)? {
            // SAFETY: checked, and the caller's promise.
            Ok(unsafe { slice::from_raw_parts(start, count) })
        } else {
            Ok(&[])
        }
    }

    /// The same of what may be left out: nothing where `start` is null.
    ///
    /// # Safety
    /// As for [`read`](Self::read).
    pub unsafe fn read_given<'a, T>(&mut self, start: *const T, count: usize) -> Result<Option<&'a [T]>, Fault> {
        // SAFETY: the caller's promise.
        if start.is_null() { Ok(None) } else { unsafe { self.read(start, count).map(Some) } }
    }

    /// `count` values of `T` to write.
    ///
    /// # Safety
    /// As for [`read`](Self::read), and nobody reads them.
    pub unsafe fn write<'a, T>(&mut self, start: *mut T, count: usize) -> Result<&'a mut [T], Fault> {
        if self.claim(start, count, true)? {
            // SAFETY: checked, and the caller's promise.
            Ok(unsafe { slice::from_raw_parts_mut(start, count) })
        } else {
            Ok(&mut [])
        }
    }

    /// Notes the bytes; false where there are none.
    fn claim<T>(&mut self, start: *const T, count: usize, is_written: bool) -> Result<bool, Fault> {
        if count == 0 {
            return Ok(false);
        }
        check(start)?;
        let first = start.addr();
        let bytes = count.checked_mul(size_of::<T>()).filter(|bytes| *bytes <= isize::MAX as usize);
        let end = bytes.and_then(|bytes| first.checked_add(bytes)).ok_or(Fault::new(SEAMWRIGHT_TOO_LARGE))?;
        let shares = |(other, other_is_written): &(Range<usize>, bool)| {
            (is_written || *other_is_written) && first < other.end && other.start < end
        };
        if self.seen[..self.count].iter().any(shares) {
            return Err(Fault::new(SEAMWRIGHT_SHARED));
        }
        self.seen[self.count] = (first..end, is_written);
        self.count += 1;
        debug_assert!(first.is_multiple_of(align_of::<T>()));
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault<T>(result: Result<T, Fault>) -> i32 {
        result.err().map_or(0, |f| f.code)
    }

    #[test]
    fn pointers_are_checked_before_they_are_believed() {
        let mut values = [0u64; 4];
        let start = values.as_mut_ptr();
        let odd = start.cast::<u8>().wrapping_add(1).cast::<u64>();
        // SAFETY: whatever is handed out is not used.
        unsafe {
            let mut all = Buffers::default();
            assert_eq!(fault(all.read::<u64>(core::ptr::null(), 1)), SEAMWRIGHT_NULL);
            assert_eq!(fault(all.read(odd, 1)), SEAMWRIGHT_MISALIGNED);
            assert_eq!(fault(all.read(start, usize::MAX / 8)), SEAMWRIGHT_TOO_LARGE);
            assert_eq!(fault(all.read(start, usize::MAX)), SEAMWRIGHT_TOO_LARGE);
            assert_eq!(all.read::<u64>(core::ptr::null(), 0).map(<[u64]>::len), Ok(0));
            assert_eq!(all.read_given::<u64>(core::ptr::null(), 1).map(|list| list.is_none()), Ok(true));
            assert_eq!(fault(all.read_given(odd, 1)), SEAMWRIGHT_MISALIGNED);
        }
    }

    #[test]
    fn what_is_written_is_nobody_elses() {
        let mut values = [0u64; 4];
        let start = values.as_mut_ptr();
        // SAFETY: whatever is handed out is not used.
        unsafe {
            let mut all = Buffers::default();
            assert_eq!(fault(all.read(start, 2)), 0);
            assert_eq!(fault(all.read(start.add(1), 1)), 0);
            assert_eq!(fault(all.write(start.add(1), 1)), SEAMWRIGHT_SHARED);
            assert_eq!(fault(all.write(start.add(2), 2)), 0);
            assert_eq!(fault(all.read(start.add(3), 1)), SEAMWRIGHT_SHARED);
        }
    }
}
