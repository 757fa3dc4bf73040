//! Memory for core, as much as it asks for.
//!
//! Core says beforehand how much memory it wants, an estimate from above for meshes as they occur. Where a mesh needs
//! more, the run starts again with twice as much, until that does not help or the machine has no more to give.

use crate::base::failure::Failure;
use core::sync::atomic::{AtomicBool, Ordering};
use seamwright_core::base::scratch::ScratchTooSmall;
use seamwright_core::pipeline::UnwrapError;
use seamwright_core::transfer::report::TransferError;

/// Runs `work` with `need` bytes, and with twice as many as often as it asks for more. The error is that there are no
/// more; what else `work` says is handed on, as is a request that more memory does not change.
pub(super) fn with_enough<T, E: Lacking>(
    mut need: usize,
    mut work: impl FnMut(&mut [u8]) -> Result<T, E>,
) -> Result<Result<T, E>, Failure> {
    let mut last = None;
    loop {
        let result = work(&mut memory(need)?);
        match result.as_ref().err().and_then(Lacking::lacks) {
            Some(e) if e.need > e.given && last != Some(e) => {
                last = Some(e);
                // The request is one slice of many, so it says the least that is missing, not all of it.
                need = need.saturating_mul(2).max(need.saturating_add(e.need - e.given));
            }
            _ => return Ok(result),
        }
    }
}

/// An error that may be a want of memory.
pub(super) trait Lacking {
    /// The memory that was missing.
    fn lacks(&self) -> Option<ScratchTooSmall>;
}

impl Lacking for UnwrapError {
    fn lacks(&self) -> Option<ScratchTooSmall> {
        if let UnwrapError::Scratch(e) = self { Some(*e) } else { None }
    }
}

impl Lacking for TransferError {
    fn lacks(&self) -> Option<ScratchTooSmall> {
        if let TransferError::Scratch(e) = self { Some(*e) } else { None }
    }
}

/// What is printed where memory runs out in the middle of something.
pub const SPENT: &str = "seamwright: no more memory is to be had; free some or simplify the mesh\n";

/// Set while a piece is asked for that can be done without.
static TRIES: AtomicBool = AtomicBool::new(false);

/// Whether whoever asks for memory now takes a no for an answer.
pub fn can_do_without() -> bool {
    TRIES.load(Ordering::Relaxed)
}

/// Zeroed bytes. Pages that are never touched cost nothing.
fn memory(need: usize) -> Result<Box<[u8]>, Failure> {
    TRIES.store(true, Ordering::Relaxed);
    let bytes = bytemuck::allocation::try_zeroed_slice_box(need);
    TRIES.store(false, Ordering::Relaxed);
    bytes.map_err(|()| {
        let gigabytes = need as f64 / f64::from(1u32 << 30);
        Failure::Unreached(format!("{gigabytes:.1} GiB of memory are not to be had; free some or simplify the mesh"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_nobody_has_is_an_error() {
        assert_eq!(memory(usize::MAX).map(|_| ()).map_err(|e| e.code()), Err(5));
        assert!(memory(1000).is_ok_and(|m| m.iter().all(|b| *b == 0)));
    }

    #[test]
    fn memory_grows_until_it_is_enough_or_does_not_help_or_there_is_none() {
        fn short<T>(need: usize, given: usize) -> Result<T, UnwrapError> {
            Err(UnwrapError::Scratch(ScratchTooSmall { need, given }))
        }
        let mut tries = vec![];
        let done = with_enough(100, |bytes| {
            tries.push(bytes.len());
            if bytes.len() < 350 { short(40, bytes.len() / 10) } else { Ok(bytes.len()) }
        });
        assert_eq!((done, tries), (Ok(Ok(400)), vec![100, 200, 400]));
        assert_eq!(with_enough(100, |b| if b.len() == 100 { short(950, 50) } else { Ok(b.len()) }), Ok(Ok(1000)));
        assert_eq!(with_enough(100, |_| short::<()>(2, 1)), Ok(short(2, 1)));
        assert_eq!(with_enough(100, |_| short::<()>(usize::MAX, 1)).map_err(|e| e.code()), Err(5));
        assert_eq!(with_enough(1, |_| Err::<(), _>(UnwrapError::Cancelled)), Ok(Err(UnwrapError::Cancelled)));
    }
}
