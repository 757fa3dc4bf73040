//! Threads for core's tasks.
//!
//! Each thread takes the next task from one counter, so a slow task holds up nobody. Which thread runs a task, and how
//! many there are, changes nothing that a task writes (see `core::base::workers`).
//! A task that panics ends the whole run with its panic once the other threads have finished theirs; nothing hangs.

use core::sync::atomic::{AtomicUsize, Ordering};
use seamwright_core::base::workers::Workers;
use std::thread::available_parallelism;

/// A fixed number of threads that wait for tasks.
pub struct Pool {
    threads: rayon::ThreadPool,
}

impl Pool {
    /// Starts `count` threads, or as many as the machine runs at once.
    pub fn new(count: Option<usize>) -> Result<Self, rayon::ThreadPoolBuildError> {
        let count = count.or_else(|| available_parallelism().ok().map(usize::from)).unwrap_or(1);
        let threads = rayon::ThreadPoolBuilder::new().num_threads(count).build()?;
        Ok(Self { threads })
    }

    /// Does `work` on one of the threads: from there tasks are begun and awaited without waking another.
    pub fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.threads.install(work)
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        self.threads.current_num_threads()
    }
}

impl Workers for Pool {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        if count <= 1 || self.count() == 1 {
            return (0..count).for_each(task);
        }
        let next = AtomicUsize::new(0);
        let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count);
        let work = || {
            while let Some(i) = take() {
                task(i);
            }
        };
        // Where this is a task itself, other threads may be busy for long: nobody waits for them to look in here.
        self.threads.scope(|scope| {
            (1..self.count().min(count)).for_each(|_| scope.spawn(|_| work()));
            work();
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seamwright_core::base::workers::for_each_chunk;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    #[test]
    fn every_task_runs_once_with_any_number_of_threads() {
        for threads in [1, 2, 7] {
            let pool = Pool::new(Some(threads)).unwrap();
            let mut data = vec![0usize; 1001];
            for_each_chunk(&pool, &mut data, 3, &|i, chunk| chunk.iter_mut().for_each(|x| *x += i + 1));
            assert!(data.iter().enumerate().all(|(i, x)| *x == i / 3 + 1));
        }
    }

    #[test]
    fn a_task_may_run_tasks_of_its_own() {
        let pool = Pool::new(Some(3)).unwrap();
        let sum = AtomicUsize::new(0);
        pool.run(10, &|i| {
            pool.run(10, &|j| {
                sum.fetch_add(10 * i + j, Ordering::Relaxed);
            });
        });
        assert_eq!(sum.into_inner(), 4950);
    }

    #[test]
    fn a_panic_reaches_the_caller_and_the_pool_lives_on() {
        let pool = Pool::new(Some(2)).unwrap();
        let result = catch_unwind(AssertUnwindSafe(|| pool.run(100, &|i| assert_ne!(i, 50, "task 50 fails"))));
        assert!(result.is_err());
        let sum = AtomicUsize::new(0);
        pool.run(4, &|i| {
            sum.fetch_add(i, Ordering::Relaxed);
        });
        assert_eq!(sum.into_inner(), 6);
    }

    #[test]
    fn no_task_is_no_work() {
        Pool::new(Some(2)).unwrap().run(0, &|_| unreachable!());
    }
}
