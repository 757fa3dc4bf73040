//! Bump allocation over one byte slice that the caller owns.
//!
//! [`Scratch::take`] hands out zeroed typed slices; [`Scratch::frame`] opens a scope whose memory comes back when
//! the frame is dropped. Safe Rust only: `mem::take`, splitting of slices and `bytemuck` casts.
//! Limits: a slice is aligned by skipping bytes, so a frame may use up to `align - 1` bytes more a slice than its data.

use super::slices::take_first;
use bytemuck::{Pod, pod_align_to_mut};
use core::mem::{align_of, size_of, take};

/// Alignment that [`bytes_for`] assumes for every slice: the largest that a stage uses.
pub const ALIGN: usize = 16;

/// The scratch slice has fewer bytes than the stage needs. Nothing was written to any output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScratchTooSmall {
    /// Bytes that would have been enough for the failing request (counted from where it began).
    pub need: usize,
    /// Bytes that were there.
    pub given: usize,
}

impl core::fmt::Display for ScratchTooSmall {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "scratch memory too small: {} bytes needed, {} given", self.need, self.given)
    }
}

impl core::error::Error for ScratchTooSmall {}

/// Bytes that [`Scratch::take`] of `count` values of `T` uses at the most, alignment included.
pub const fn bytes_for<T>(count: usize) -> usize {
    count.saturating_mul(size_of::<T>()).saturating_add(ALIGN)
}

/// A bump allocator over the caller's bytes.
pub struct Scratch<'a> {
    free: &'a mut [u8],
}

impl<'a> Scratch<'a> {
    /// All of `bytes` is free.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { free: bytes }
    }

    /// Free bytes left.
    pub fn remaining(&self) -> usize {
        self.free.len()
    }

    /// Fails unless `need` bytes are free. A stage calls it before it writes anything.
    pub fn require(&self, need: usize) -> Result<(), ScratchTooSmall> {
        if self.free.len() < need { Err(ScratchTooSmall { need, given: self.free.len() }) } else { Ok(()) }
    }

    /// A slice of `count` zeroed values that lives as long as this frame.
    pub fn take<T: Pod>(&mut self, count: usize) -> Result<&'a mut [T], ScratchTooSmall> {
        let out = self.take_unset::<T>(count)?;
        out.fill(T::zeroed());
        Ok(out)
    }

    /// Like [`take`](Self::take), with whatever stood in the memory: for a slice that is written before it is read.
    pub fn take_unset<T: Pod>(&mut self, count: usize) -> Result<&'a mut [T], ScratchTooSmall> {
        let given = self.free.len();
        let skip = self.free.as_ptr().align_offset(align_of::<T>());
        let need = skip.saturating_add(count.saturating_mul(size_of::<T>()));
        self.require(need)?;
        let (_, values, _) = pod_align_to_mut(take_first(&mut self.free, need));
        values.get_mut(..count).ok_or(ScratchTooSmall { need, given })
    }

    /// Like [`take`](Self::take), with every value set to `value`.
    pub fn take_filled<T: Pod>(&mut self, count: usize, value: T) -> Result<&'a mut [T], ScratchTooSmall> {
        let out = self.take(count)?;
        out.fill(value);
        Ok(out)
    }

    /// A slice whose length is only known once it is filled: `write` gets all free memory as values of `T` (not
    /// zeroed) and answers how many it used, or `None` where the memory was not enough.
    pub fn fill<T: Pod>(
        &mut self,
        write: impl FnOnce(&mut [T]) -> Option<usize>,
    ) -> Result<&'a mut [T], ScratchTooSmall> {
        let given = self.free.len();
        // What is left at the end for less than one T is given up.
        let (_, mut values, _) = pod_align_to_mut(take(&mut self.free));
        let Some(len) = write(values) else {
            return Err(ScratchTooSmall { need: given + 1, given });
        };
        let len = len.min(values.len());
        let used = take_first(&mut values, len);
        (_, self.free, _) = pod_align_to_mut(values);
        Ok(used)
    }

    /// Splits off `bytes` free bytes as an allocator of their own, for a task that runs beside this one.
    pub fn split(&mut self, bytes: usize) -> Result<Scratch<'a>, ScratchTooSmall> {
        self.require(bytes)?;
        Ok(Scratch { free: take_first(&mut self.free, bytes) })
    }

    /// A scope: what it takes comes back when it ends.
    pub fn frame(&mut self) -> Scratch<'_> {
        Scratch { free: self.free }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn a_frame_gives_its_memory_back() {
        let mut bytes = vec![1u8; 256];
        let mut scratch = Scratch::new(&mut bytes);
        let before = scratch.remaining();
        {
            let mut frame = scratch.frame();
            assert_eq!(frame.take::<u64>(8).unwrap(), &[0; 8]);
            assert!(frame.remaining() < before);
        }
        assert_eq!(scratch.remaining(), before);
    }

    #[test]
    fn slices_are_aligned_and_disjoint() {
        let mut bytes = vec![0u8; 256];
        let mut scratch = Scratch::new(&mut bytes);
        let a = scratch.take_filled::<u8>(3, 7).unwrap();
        let b = scratch.take_filled::<f64>(4, 1.5).unwrap();
        assert_eq!((a, b), (&mut [7u8; 3][..], &mut [1.5; 4][..]));
    }

    #[test]
    fn one_byte_less_is_refused_with_the_numbers() {
        let mut bytes = vec![0u8; 15];
        let mut scratch = Scratch::new(&mut bytes);
        assert_eq!(scratch.take::<u8>(16), Err(ScratchTooSmall { need: 16, given: 15 }));
        assert_eq!(scratch.take::<u8>(15).unwrap().len(), 15);
    }
}
