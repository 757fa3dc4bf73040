//! The golden runs give the golden hashes, on every path that this machine has and with 1, 2 and 7 threads.

#![cfg(test)]

use crate::{MEMORY, SEED, run};
use core::sync::atomic::{AtomicUsize, Ordering};
use seamwright_core::base::workers::Workers;
use seamwright_core::learn::kernels::path::Path;
use std::{println, string::String, thread, vec};

const GOLDEN: &str = include_str!("../../../fixtures/golden/hashes");

/// So many threads that take the next task from a counter.
struct Threads(usize);

impl Workers for Threads {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        thread::scope(|scope| {
            for _ in 0..self.0.min(count) {
                scope.spawn(|| {
                    while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count) {
                        task(i);
                    }
                });
            }
        });
    }
}

fn hashes(seed: u64, path: Path, threads: usize) -> String {
    let mut out = String::new();
    run(&mut out, seed, &mut vec![0; MEMORY], path, &Threads(threads)).expect("the golden meshes unwrap");
    out
}

#[test]
fn every_path_and_number_of_threads_gives_the_golden_hashes() {
    for path in Path::ALL {
        if !path.is_available() {
            println!("skipped: this machine has no {path:?}");
            continue;
        }
        for threads in [1, 2, 7] {
            let found = hashes(SEED, path, threads);
            assert_eq!(found, GOLDEN, "{path:?}, {threads} threads: see docs/REPRODUCIBILITY.md");
            println!("{path:?}, {threads} threads: the golden hashes");
        }
    }
}

#[test]
fn another_seed_changes_the_hash_of_every_stage_that_draws() {
    let found = hashes(SEED + 1, Path::best(), 1);
    for stage in ["exposure", "labels", "weights", "uvs", "metrics", "map"] {
        let same = |line: &&str| line.contains(stage) && GOLDEN.lines().any(|golden| golden == *line);
        assert_eq!(found.lines().find(same), None, "{stage}");
    }
}
