//! NEON path of aarch64: tiles of 6 x 16. Every aarch64 machine with floating point has the instructions.
//!
//! `unsafe` lives here: vector instructions that the target has by definition.

use super::task::{RowTask, padded};
use core::arch::aarch64::*;

/// Columns of a packed panel.
pub(super) const WIDTH: usize = wide128::WIDTH;

/// See [`super::float::Float::fill_rows`].
pub(super) fn fill_rows(mut task: RowTask<f32>) {
    task.packed = &task.packed[..padded(task.columns, WIDTH) * task.depth];
    // SAFETY: this file is compiled where the target has NEON, and the packed panels are complete.
    unsafe { wide128::fill_rows(task) }
}

/// a b + c, rounded once.
#[inline]
#[target_feature(enable = "neon")]
fn fused(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
    vfmaq_f32(c, a, b)
}

tiles!(wide128, "neon", 4, 4, float32x4_t, vld1q_f32, vst1q_f32, vdupq_n_f32, fused);
