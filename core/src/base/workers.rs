//! Independent tasks, run by whatever the caller has: core never spawns a thread.
//!
//! A stage cuts its work into tasks whose number and borders do not depend on the machine, and each task writes only
//! its own outputs, so the result is the same for any number of threads and any order.
//! The numbers that workers call with are not believed: each call takes the next chunk, so that one which leaves out tasks or
//! repeats them changes nothing. Where a target has no atomic counter, tasks run one after the other.
//! `unsafe` lives here in one place: handing each task its own chunk of a slice.

use core::marker::PhantomData;
#[cfg(target_has_atomic = "ptr")]
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Runs independent tasks.
pub trait Workers: Sync {
    /// Calls `task(i)` exactly once for each i in `0..count`, in any order, on any thread; returns when all are done.
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync));
}

/// One thread, in order: for embedded callers and as the reference.
pub struct Serial;

impl Workers for Serial {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(task);
    }
}

/// A slice cut into chunks that different tasks write at the same time.
struct Chunks<'a, T> {
    start: *mut T,
    len: usize,
    chunk: usize,
    slice: PhantomData<&'a mut [T]>,
}

// SAFETY: `Chunks` only hands out disjoint sub-slices (see `get`), each to the one task that owns its index.
unsafe impl<T: Send> Sync for Chunks<'_, T> {}

impl<'a, T> Chunks<'a, T> {
    fn new(slice: &'a mut [T], chunk: usize) -> Self {
        Self { start: slice.as_mut_ptr(), len: slice.len(), chunk, slice: PhantomData }
    }

    /// SAFETY: the caller uses each index once.
    #[allow(clippy::mut_from_ref)]
    unsafe fn get(&self, index: usize) -> &mut [T] {
        let first = index.saturating_mul(self.chunk).min(self.len);
        let last = first.saturating_add(self.chunk).min(self.len);
        // SAFETY: first <= last <= len, and chunks of different indices do not overlap.
        unsafe { core::slice::from_raw_parts_mut(self.start.add(first), last - first) }
    }
}

/// Calls `task(i, chunk_i)` for each chunk of `chunk` values (the last may be shorter).
pub fn for_each_chunk<T: Send>(
    workers: &dyn Workers,
    slice: &mut [T],
    chunk: usize,
    task: &(dyn Fn(usize, &mut [T]) + Sync),
) {
    let chunk = chunk.max(1);
    let count = slice.len().div_ceil(chunk);
    let chunks = Chunks::new(slice, chunk);
    #[cfg(target_has_atomic = "ptr")]
    {
        let next = AtomicUsize::new(0);
        // False where all are taken. The first look keeps the counter from running over.
        let take = || {
            let index = if next.load(Relaxed) < count { next.fetch_add(1, Relaxed) } else { count };
            if index < count {
                // SAFETY: the counter gives each index once.
                task(index, unsafe { chunks.get(index) });
            }
            index < count
        };
        workers.run(count, &|_| {
            take();
        });
        while take() {}
    }
    #[cfg(not(target_has_atomic = "ptr"))]
    {
        let _ = workers;
        // SAFETY: each index once.
        (0..count).for_each(|i| task(i, unsafe { chunks.get(i) }));
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::{thread, vec};

    /// A thread for each task, the last one begun first.
    pub(crate) struct Backwards;
    impl Workers for Backwards {
        fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
            thread::scope(|scope| {
                for i in (0..count).rev() {
                    scope.spawn(move || task(i));
                }
            });
        }
    }

    /// Repeats a task, invents one and leaves out the rest.
    struct Careless;
    impl Workers for Careless {
        fn run(&self, _: usize, task: &(dyn Fn(usize) + Sync)) {
            [1, 1, usize::MAX].into_iter().for_each(task);
        }
    }

    #[test]
    fn every_chunk_is_written_once_in_any_order() {
        let fill = |workers: &dyn Workers| {
            let mut data = vec![0usize; 23];
            for_each_chunk(workers, &mut data, 5, &|i, chunk| chunk.iter_mut().for_each(|x| *x += i + 1));
            data
        };
        assert_eq!(fill(&Serial), fill(&Backwards));
        assert_eq!(fill(&Serial), fill(&Careless));
        assert_eq!(fill(&Serial)[22], 5);
    }

    #[test]
    fn an_empty_slice_runs_no_task() {
        for_each_chunk(&Serial, &mut [0u8; 0], 4, &|_, _| panic!("no chunk"));
    }
}
