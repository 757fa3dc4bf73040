//! Structs that begin with their size, so that they can grow at their end and programs of another age still be understood.
//!
//! A program older than the library has shorter structs: what they lack is zero where it is read, and zero says nothing; it
//! is left out where it is written. A newer program has longer ones: what this library does not know must be zero where it is
//! read, and stays as it was where it is written. A struct is taken byte by byte, since an older one may ask for less
//! alignment than today's. `unsafe` lives here: what cannot be checked is that as many bytes are there as a struct says.

use crate::code::{Fault, SEAMWRIGHT_BAD_STRUCT, SEAMWRIGHT_NEWER_STRUCT};
use crate::slices::check;
use crate::types::*;
use core::mem::{self, MaybeUninit, offset_of};
use core::{ptr, slice};

/// Bytes of the longest struct that is believed, ten times today's: more is a size that was never set.
const MOST: usize = 4096;

/// A struct that crosses the border.
///
/// # Safety
/// It is `repr(C)`, begins with its size, and takes zeros and whatever else a caller may write there.
pub unsafe trait Growing: Copy {
    /// Bytes up to the last field of its first version.
    const LEAST: usize;
}

/// `Growing: last field of the first version, last field`. Bytes at a struct's end that belong to no field would be of any
/// value where the next version's field is.
macro_rules! growing {
    ($($name:ident: $first:ident, $last:ident;)*) => {$(
        // SAFETY: numbers and pointers in the order of C, looked at below; functions may be null.
        unsafe impl Growing for $name {
            const LEAST: usize = end(offset_of!($name, $first), |x: $name| x.$first);
        }
        impl $name {
            /// Its size, and zeros, which say nothing: C's `..._INIT`.
            // SAFETY: as above.
            pub const INIT: Self = Self { struct_size: size_of::<Self>(), ..unsafe { mem::zeroed() } };
        }
        const _: () = assert!(offset_of!($name, struct_size) == 0);
        const _: () = assert!(end(offset_of!($name, $last), |x: $name| x.$last) == size_of::<$name>());
    )*};
}

growing! {
    SeamwrightMesh: parts, tolerance;
    SeamwrightOptions: effort, may_finish;
    SeamwrightAtlas: exposure, exposure;
    SeamwrightReport: detail, ended_early;
    SeamwrightFigures: detail, sharp_seam_cover;
    SeamwrightHost: run, run;
}

/// Where the field behind `_field` ends.
const fn end<T, F>(offset: usize, _field: fn(T) -> F) -> usize {
    offset + size_of::<F>()
}

/// Reads a struct.
///
/// # Safety
/// A pointer that is not null and aligned points to as many bytes as stand there first.
pub unsafe fn read<T: Growing>(at: *const T) -> Result<T, Fault> {
    // SAFETY: the caller's promise.
    let size = unsafe { size_at(at)? };
    let (bytes, known) = (at.cast::<u8>(), size.min(size_of::<T>()));
    // SAFETY: no more than the caller says is there.
    let beyond = unsafe { slice::from_raw_parts(bytes.add(known), size - known) };
    if beyond.iter().any(|byte| *byte != 0) {
        return Err(Fault::at(SEAMWRIGHT_NEWER_STRUCT, known));
    }
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: `known` bytes are there on both sides; the fields take them, and zeros (`Growing`).
    unsafe {
        ptr::copy_nonoverlapping(bytes, value.as_mut_ptr().cast(), known);
        Ok(value.assume_init())
    }
}

/// Where a struct is written.
pub struct Room<T> {
    at: *mut T,
    size: usize,
}

impl<T: Growing> Room<T> {
    /// Looks at the size that stands there.
    ///
    /// # Safety
    /// As for [`read`].
    pub unsafe fn new(at: *mut T) -> Result<Self, Fault> {
        // SAFETY: the caller's promise.
        unsafe { size_at(at).map(|size| Self { at, size }) }
    }

    /// Takes `size` bytes whatever stands there, and makes them a struct of zeros.
    ///
    /// # Safety
    /// A pointer that is not null and aligned points to `size` bytes.
    pub unsafe fn cleared(at: *mut T, size: usize) -> Result<Self, Fault> {
        check(at.cast::<usize>())?;
        let size = believed::<T>(size)?;
        // SAFETY: checked, and the caller's promise.
        unsafe {
            at.cast::<u8>().write_bytes(0, size);
            at.cast::<usize>().write(size);
        }
        Ok(Self { at, size })
    }

    /// Writes as much of `value` as is there, behind the size, which stays.
    ///
    /// # Safety
    /// The bytes are still there, and nobody looks at them.
    pub unsafe fn write(self, value: T) {
        let known = self.size.min(size_of::<T>());
        let from = (&raw const value).cast::<u8>();
        let skip = size_of::<usize>();
        // SAFETY: the size is checked, so both have these bytes.
        unsafe { ptr::copy_nonoverlapping(from.add(skip), self.at.cast::<u8>().add(skip), known - skip) };
    }
}

/// The size that a struct says it has.
///
/// # Safety
/// As for [`read`].
unsafe fn size_at<T: Growing>(at: *const T) -> Result<usize, Fault> {
    let first = at.cast::<usize>();
    check(first)?;
    // SAFETY: checked, and the caller's promise.
    believed::<T>(unsafe { first.read() })
}

/// `size`, where a struct of any age can have it: what begins with a size_t has no other, so no pointer is cut in two.
fn believed<T: Growing>(size: usize) -> Result<usize, Fault> {
    let is_whole = size.is_multiple_of(size_of::<usize>());
    if is_whole && (T::LEAST..=MOST).contains(&size) {
        Ok(size)
    } else {
        Err(Fault::at(SEAMWRIGHT_BAD_STRUCT, size_of::<T>()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{SEAMWRIGHT_MISALIGNED, SEAMWRIGHT_NULL};

    /// A struct with a field that its first version lacks, and what a newer one has behind it.
    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Own {
        struct_size: usize,
        first: usize,
        second: usize,
    }

    // SAFETY: numbers only.
    unsafe impl Growing for Own {
        const LEAST: usize = 2 * size_of::<usize>();
    }

    const WORD: usize = size_of::<usize>();

    fn code<T>(result: Result<T, Fault>) -> (i32, usize) {
        result.err().map_or((0, 0), |fault| (fault.code, fault.detail))
    }

    fn taken(words: [usize; 5]) -> Result<Own, Fault> {
        // SAFETY: five words are there, and the sizes below that are believed are no more.
        unsafe { read(words.as_ptr().cast()) }
    }

    #[test]
    fn a_short_struct_lacks_what_it_does_not_have() {
        let own = |struct_size, second| Own { struct_size, first: 7, second };
        assert_eq!(taken([3 * WORD, 7, 8, 9, 9]), Ok(own(3 * WORD, 8)));
        assert_eq!(taken([2 * WORD, 7, 8, 9, 9]), Ok(own(2 * WORD, 0)));
    }

    #[test]
    fn a_long_struct_is_taken_where_it_says_nothing_more() {
        assert!(taken([5 * WORD, 7, 8, 0, 0]).is_ok_and(|own| own.second == 8));
        assert_eq!(code(taken([5 * WORD, 7, 8, 0, 1])), (SEAMWRIGHT_NEWER_STRUCT, 3 * WORD));
        assert_eq!(code(taken([4 * WORD, 7, 8, 1 << 7, 0])), (SEAMWRIGHT_NEWER_STRUCT, 3 * WORD));
        assert_eq!(code(taken([4 * WORD, 7, 8, 0, 1])), (0, 0));
    }

    #[test]
    fn a_size_that_no_version_has_is_not_believed() {
        for size in [0, 1, WORD, 2 * WORD - 1, 2 * WORD + 1, MOST + WORD, usize::MAX, usize::MAX - WORD + 1] {
            assert_eq!(code(taken([size, 7, 8, 0, 0])), (SEAMWRIGHT_BAD_STRUCT, 3 * WORD), "{size}");
        }
        let mut word = 0usize;
        let odd = (&raw mut word).wrapping_byte_add(1).cast::<Own>();
        // SAFETY: neither is read.
        unsafe {
            assert_eq!(code(read::<Own>(ptr::null())), (SEAMWRIGHT_NULL, 0));
            assert_eq!(code(read(odd)), (SEAMWRIGHT_MISALIGNED, 0));
            assert_eq!(code(Room::<Own>::cleared(odd, 24)), (SEAMWRIGHT_MISALIGNED, 0));
            assert_eq!(code(Room::<Own>::cleared((&raw mut word).cast(), 8)), (SEAMWRIGHT_BAD_STRUCT, 3 * WORD));
        }
        assert_eq!(word, 0);
    }

    #[test]
    fn what_is_written_ends_where_the_struct_does() {
        let value = Own { struct_size: 99, first: 1, second: 2 };
        for (size, expected) in [(2, [1, 7, 7]), (3, [1, 2, 7]), (4, [1, 2, 7])] {
            let mut words = [size * WORD, 7, 7, 7];
            // SAFETY: four words are there.
            unsafe { Room::new(words.as_mut_ptr().cast()).unwrap().write(value) };
            assert_eq!((words[0], &words[1..]), (size * WORD, &expected[..]));
        }
        let mut words = [7; 4];
        // SAFETY: four words are there.
        unsafe { Room::cleared(words.as_mut_ptr().cast(), 4 * WORD).unwrap().write(value) };
        assert_eq!(words, [4 * WORD, 1, 2, 0]);
    }
}
