//! What a call can answer: a code, a sentence for each, and how core's errors become codes.

use core::ffi::{CStr, c_char};
use seamwright_core::judge::measure::MeasureError;
use seamwright_core::pipeline::UnwrapError;

/// Done.
pub const SEAMWRIGHT_OK: i32 = 0;
/// A pointer is null where something is needed.
pub const SEAMWRIGHT_NULL: i32 = 1;
/// A pointer is not aligned for what it points to.
pub const SEAMWRIGHT_MISALIGNED: i32 = 2;
/// A buffer that is written shares bytes with another one.
pub const SEAMWRIGHT_SHARED: i32 = 3;
/// A count is larger than 32-bit corner numbers or the address space reach.
pub const SEAMWRIGHT_TOO_LARGE: i32 = 4;
/// Triangles were promised, but `corner_count` is not 3 `polygon_count`; or `polygon_start` does not begin with 0, falls,
/// or does not end with `corner_count`. `detail`: the polygon.
pub const SEAMWRIGHT_BAD_POLYGONS: i32 = 5;
/// A corner names a vertex that is not there. `detail`: the corner.
pub const SEAMWRIGHT_BAD_INDEX: i32 = 6;
/// A coordinate of a vertex is NaN or infinite. `detail`: the vertex.
pub const SEAMWRIGHT_NOT_FINITE: i32 = 7;
/// No polygon has three different corners.
pub const SEAMWRIGHT_NO_TRIANGLE: i32 = 8;
/// `distortion` is not a number above 1.
pub const SEAMWRIGHT_BAD_DISTORTION: i32 = 9;
/// `size` is not from 16 to 65536, or `padding` is more than a quarter of it.
pub const SEAMWRIGHT_BAD_SIZE: i32 = 10;
/// `rays` is not from 1 to 65536.
pub const SEAMWRIGHT_BAD_RAYS: i32 = 11;
/// `charts`, `packing`, `hard_edges`, `prefer`, `straighten` or `stack` is none of their constants, `stack_offset` above 1, or `weld` neither its
/// own nor 0 to 0.01.
pub const SEAMWRIGHT_BAD_CHOICE: i32 = 12;
/// More scratch memory is needed. `detail`: bytes to try next, which changes no bit of the result; 0: no amount would do.
pub const SEAMWRIGHT_SCRATCH: i32 = 13;
/// The progress callback asked to stop.
pub const SEAMWRIGHT_CANCELLED: i32 = 14;
/// Faces of the atlas still overlap after all attempts; please report the mesh. `detail`: how many.
pub const SEAMWRIGHT_OVERLAP: i32 = 15;
/// `effort` is more than 1000, or `search` more than 100.
pub const SEAMWRIGHT_BAD_EFFORT: i32 = 16;
/// A fault of this library; please report it.
pub const SEAMWRIGHT_INTERNAL: i32 = 17;
/// `struct_size` is no sizeof of that struct: 0, less than its first version had, not a multiple of sizeof(size_t), or more
/// than 4096. `detail`: its sizeof in this library.
pub const SEAMWRIGHT_BAD_STRUCT: i32 = 18;
/// A struct of a newer header says something that this library does not know: bytes behind its last known field are not 0.
/// `detail`: how many bytes are known.
pub const SEAMWRIGHT_NEWER_STRUCT: i32 = 19;

/// A sentence for people about a code.
#[unsafe(no_mangle)]
pub extern "C" fn seamwright_message(code: i32) -> *const c_char {
    message(code).as_ptr()
}

fn message(code: i32) -> &'static CStr {
    match code {
        SEAMWRIGHT_OK => c"done",
        SEAMWRIGHT_NULL => c"a pointer is null where something is needed",
        SEAMWRIGHT_MISALIGNED => c"a pointer is not aligned for what it points to",
        SEAMWRIGHT_SHARED => c"a buffer that is written shares bytes with another one",
        SEAMWRIGHT_TOO_LARGE => c"a count is larger than 32-bit corner numbers or the address space reach",
        SEAMWRIGHT_BAD_POLYGONS => c"the polygons' first corners do not rise from 0 to the number of corners",
        SEAMWRIGHT_BAD_INDEX => c"a corner names a vertex that does not exist",
        SEAMWRIGHT_NOT_FINITE => c"a vertex has a coordinate that is not a number",
        SEAMWRIGHT_NO_TRIANGLE => c"the mesh holds no triangle with three different corners",
        SEAMWRIGHT_BAD_DISTORTION => c"the bound on distortion must be a number above 1",
        SEAMWRIGHT_BAD_SIZE => c"the size must be from 16 to 65536, the padding a quarter of it at the most",
        SEAMWRIGHT_BAD_RAYS => c"the number of rays must be from 1 to 65536",
        SEAMWRIGHT_BAD_CHOICE => {
            c"charts, packing, hard_edges, prefer, straighten, stack, stack_offset or weld is none of the known values"
        }
        SEAMWRIGHT_SCRATCH => c"more scratch memory is needed",
        SEAMWRIGHT_CANCELLED => c"stopped on request",
        SEAMWRIGHT_OVERLAP => c"faces of the atlas still overlap after all attempts",
        SEAMWRIGHT_INTERNAL => c"a fault of the library",
        SEAMWRIGHT_BAD_STRUCT => c"a struct does not begin with its size",
        SEAMWRIGHT_NEWER_STRUCT => c"a struct asks for what this version of the library does not know",
        SEAMWRIGHT_BAD_EFFORT => c"the effort must be 1000 hundredths at the most, further searches 100",
        _ => c"no code of this library",
    }
}

/// A code and the number that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    pub code: i32,
    pub detail: usize,
}

impl Fault {
    pub fn new(code: i32) -> Self {
        Self { code, detail: 0 }
    }

    pub fn at(code: i32, detail: usize) -> Self {
        Self { code, detail }
    }

    /// One slice of `need` bytes did not fit in the `left` that were free of `given`.
    pub fn scratch(need: usize, left: usize, given: usize) -> Self {
        // One slice of many, so its need says the least that is missing.
        let least = given.saturating_add(need.saturating_sub(left));
        let next = least.max(given.saturating_mul(2));
        Self::at(SEAMWRIGHT_SCRATCH, if need == usize::MAX || next == usize::MAX { 0 } else { next })
    }

    pub fn of_unwrap(error: UnwrapError, given: usize) -> Self {
        match error {
            UnwrapError::Scratch(e) => Self::scratch(e.need, e.given, given),
            UnwrapError::Cancelled => Self::new(SEAMWRIGHT_CANCELLED),
            UnwrapError::NoTriangle => Self::new(SEAMWRIGHT_NO_TRIANGLE),
            UnwrapError::NotFinite { vertex } => Self::at(SEAMWRIGHT_NOT_FINITE, vertex),
            UnwrapError::BadIndex { corner } => Self::at(SEAMWRIGHT_BAD_INDEX, corner),
            // The hierarchy and the lengths are this library's.
            UnwrapError::BadTree | UnwrapError::BadLength { .. } => Self::new(SEAMWRIGHT_INTERNAL),
            UnwrapError::Overlap { faces } => Self::at(SEAMWRIGHT_OVERLAP, faces),
        }
    }

    pub fn of_measure(error: MeasureError, given: usize) -> Self {
        match error {
            MeasureError::Scratch(e) => Self::scratch(e.need, e.given, given),
            // The corner was checked before; a triangle of a fan has no number that the caller knows.
            MeasureError::BadIndex { .. } | MeasureError::BadLength { .. } => Self::new(SEAMWRIGHT_INTERNAL),
            MeasureError::TooLarge => Self::new(SEAMWRIGHT_TOO_LARGE),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_sentence_of_its_own() {
        let unknown = message(-1);
        for code in SEAMWRIGHT_OK..=SEAMWRIGHT_NEWER_STRUCT {
            assert!(message(code) != unknown);
            assert!((SEAMWRIGHT_OK..code).all(|other| message(other) != message(code)));
        }
        assert_eq!(message(SEAMWRIGHT_NEWER_STRUCT + 1), unknown);
    }

    #[test]
    fn memory_that_no_machine_has_is_not_asked_for() {
        assert_eq!(Fault::scratch(950, 50, 100), Fault::at(SEAMWRIGHT_SCRATCH, 1000));
        assert_eq!(Fault::scratch(60, 50, 100), Fault::at(SEAMWRIGHT_SCRATCH, 200));
        assert_eq!(Fault::scratch(usize::MAX, 50, 100), Fault::at(SEAMWRIGHT_SCRATCH, 0));
    }
}
