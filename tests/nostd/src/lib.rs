//! The golden runs: two small meshes through every stage in the caller's memory, and one hash a stage.
//!
//! The same bits are promised on every machine, so the same lines must come out: [`run`] writes them, `fixtures/golden/hashes`
//! holds what they should be. `main.rs` is the program of this package for machines with and without a system.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod figures;
mod golden_tests;
pub mod hash;
pub mod mesh;
pub mod stages;

use core::fmt::Write;
use seamwright_core::base::workers::Workers;
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::pipeline::Packing;
use stages::{Failure, Stages, stages};

/// Bytes that are enough for the golden meshes.
pub const MEMORY: usize = 6 << 20;
/// Seed of the golden hashes.
pub const SEED: u64 = 5;

/// Name, text and placement of each golden mesh.
const MESHES: [(&str, &str, Packing); 2] = [
    ("quadruped", include_str!("../../../fixtures/golden/quadruped.obj"), Packing::Tight),
    ("mug", include_str!("../../../fixtures/golden/mug.obj"), Packing::Grid),
];

/// Writes a line a mesh and stage: `MESH STAGE HASH`.
pub fn run(
    out: &mut dyn Write,
    seed: u64,
    memory: &mut [u8],
    path: Path,
    workers: &dyn Workers,
) -> Result<(), Failure> {
    for (name, text, packing) in MESHES {
        let Stages { exposure, labels, weights, uvs, metrics, map } =
            stages(text, packing, seed, memory, path, workers)?;
        let named = [
            ("exposure", exposure),
            ("labels", labels),
            ("weights", weights),
            ("uvs", uvs),
            ("metrics", metrics),
            ("map", map),
        ];
        for (stage, hash) in named {
            writeln!(out, "{name} {stage} {hash:016x}").map_err(|_| Failure::Output)?;
        }
    }
    Ok(())
}
