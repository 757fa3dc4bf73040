//! Bump allocation over one byte slice that the caller owns.
//!
//! [`Scratch::take`] hands out zeroed typed slices; [`Scratch::frame`] opens a scope whose memory comes back when
//! the frame is dropped. Safe Rust only: `mem::take`, splitting of slices and `bytemuck` casts.
//! A scratch may carry an alarm: once that is set every request is refused, which ends a stage within its next few steps. What was
//! under way is then thrown away.
//! Limits: a slice is aligned by skipping bytes, so a frame may use up to `align - 1` bytes more a slice than its data.

use super::slices::take_first;
use bytemuck::{Pod, pod_align_to_mut};
use core::mem::{align_of, size_of, take};
use core::sync::atomic::{AtomicBool, Ordering};

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

impl ScratchTooSmall {
    /// Not memory was missing: the alarm is set.
    pub const ALARM: Self = Self { need: usize::MAX, given: usize::MAX };

    /// Whether the request was refused because of the alarm.
    pub fn is_alarm(&self) -> bool {
        *self == Self::ALARM
    }
}

impl core::fmt::Display for ScratchTooSmall {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if self.is_alarm() {
            return write!(f, "interrupted");
        }
        write!(f, "scratch memory too small: {} bytes needed, {} given", self.need, self.given)
    }
}

impl core::error::Error for ScratchTooSmall {}

/// Bytes that [`Scratch::take`] of `count` values of `T` uses at the most, alignment included.
pub const fn bytes_for<T>(count: usize) -> usize {
    count.saturating_mul(size_of::<T>()).saturating_add(ALIGN)
}

/// Says whether what is under way will be thrown away.
#[derive(Clone, Copy)]
pub struct Alarm<'a>([Option<&'a AtomicBool>; 2]);

impl Alarm<'_> {
    /// Whether it is set.
    pub fn is_set(self) -> bool {
        self.0.iter().flatten().any(|alarm| alarm.load(Ordering::Relaxed))
    }

    /// Fails where it is set.
    pub fn check(self) -> Result<(), ScratchTooSmall> {
        if self.is_set() { Err(ScratchTooSmall::ALARM) } else { Ok(()) }
    }
}

/// A bump allocator over the caller's bytes.
pub struct Scratch<'a> {
    free: &'a mut [u8],
    alarm: Alarm<'a>,
}

impl<'a> Scratch<'a> {
    /// All of `bytes` is free.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { free: bytes, alarm: Alarm([None; 2]) }
    }

    /// All of `bytes` is free until `alarm` is set, from whatever thread.
    pub fn with_alarm(bytes: &'a mut [u8], alarm: &'a AtomicBool) -> Self {
        Self { free: bytes, alarm: Alarm([Some(alarm), None]) }
    }

    /// The same memory, which `alarm` refuses.
    pub fn under(self, alarm: Alarm<'a>) -> Self {
        Self { alarm, ..self }
    }

    /// The same memory, which `alarm` refuses as well, once it is set, for a task of which other tasks may say that nobody needs it.
    pub fn also_under(self, alarm: &'a AtomicBool) -> Self {
        let Alarm([callers, _]) = self.alarm;
        Self { alarm: Alarm([callers, Some(alarm)]), ..self }
    }

    /// The same memory, which no alarm refuses: for what nothing can be had without.
    pub fn quiet(self) -> Self {
        self.under(Alarm([None; 2]))
    }

    /// Fails once the alarm is set: for loops that take long without asking for memory.
    pub fn look_up(&self) -> Result<(), ScratchTooSmall> {
        self.alarm.check()
    }

    /// The alarm, for tasks that have no scratch.
    pub fn alarm(&self) -> Alarm<'a> {
        self.alarm
    }

    /// Free bytes left.
    pub fn remaining(&self) -> usize {
        self.free.len()
    }

    /// Fails unless `need` bytes are free. A stage calls it before it writes anything.
    pub fn require(&self, need: usize) -> Result<(), ScratchTooSmall> {
        self.look_up()?;
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
        self.look_up()?;
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
        Ok(Scratch { free: take_first(&mut self.free, bytes), alarm: self.alarm })
    }

    /// A scope: what it takes comes back when it ends.
    pub fn frame(&mut self) -> Scratch<'_> {
        Scratch { free: self.free, alarm: self.alarm }
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
    fn nothing_is_handed_out_once_the_alarm_is_set() {
        let (mut bytes, alarm, needless) = ([0u8; 64], AtomicBool::new(false), AtomicBool::new(false));
        let mut scratch = Scratch::with_alarm(&mut bytes, &alarm);
        assert!(scratch.take::<u8>(1).is_ok() && scratch.look_up().is_ok());
        let mut part = scratch.split(16).unwrap();
        alarm.store(true, Ordering::Relaxed);
        let refused = Some(ScratchTooSmall::ALARM);
        assert_eq!(part.take::<u8>(1).err(), refused);
        assert_eq!(scratch.frame().fill::<u8>(|_| Some(1)).err(), refused);
        assert_eq!(scratch.split(0).err(), refused);
        assert!(scratch.alarm().is_set());
        assert!(scratch.frame().quiet().take::<u8>(1).is_ok());
        let set = scratch.alarm();
        assert_eq!(scratch.frame().quiet().under(set).take::<u8>(1).err(), refused);
        alarm.store(false, Ordering::Relaxed);
        let mut part = part.also_under(&needless);
        assert!(part.take::<u8>(1).is_ok());
        alarm.store(true, Ordering::Relaxed);
        assert_eq!(part.take::<u8>(1).err(), refused);
        alarm.store(false, Ordering::Relaxed);
        needless.store(true, Ordering::Relaxed);
        assert_eq!(part.take::<u8>(1).err(), refused);
        assert!(scratch.take::<u8>(1).is_ok());
    }

    #[test]
    fn one_byte_less_is_refused_with_the_numbers() {
        let mut bytes = vec![0u8; 15];
        let mut scratch = Scratch::new(&mut bytes);
        assert_eq!(scratch.take::<u8>(16), Err(ScratchTooSmall { need: 16, given: 15 }));
        assert_eq!(scratch.take::<u8>(15).unwrap().len(), 15);
    }
}
