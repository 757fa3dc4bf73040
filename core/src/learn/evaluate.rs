//! A trained map at any points, in chunks, and the seam scores of a map.

use super::backbone::{Backbone, Widths};
use super::kernels::path::Path;
use super::tape::operation::Replay;
use super::tape::ops::Tape;
use super::tape::seam::NEIGHBOURS as SEAM_NEIGHBOURS;
use super::tape::var::Var;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;

/// Points of a chunk: at width 512 its values take 12 MB. 256 shares the products worse between threads.
const CHUNK: usize = 512;

/// Where the mesh lay before it was put into the unit box: x -> (x - centre) scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Centre of the box.
    pub centre: [f32; 3],
    /// 1 / its longest side.
    pub scale: f32,
}

impl Frame {
    /// The frame of positions (n, 3); the unit frame where they have no extent.
    pub fn of(positions: &[f32]) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in positions.as_chunks::<3>().0.iter() {
            for c in 0..3 {
                low[c] = low[c].min(p[c]);
                high[c] = high[c].max(p[c]);
            }
        }
        // Halves before the sum: the ends of f32 stay finite.
        let centre = core::array::from_fn(|c| low[c] * 0.5 + high[c] * 0.5);
        let side = (0..3).fold(0.0f32, |side, c| side.max(high[c] * 0.5 - low[c] * 0.5)) * 2.0;
        let scale = 1.0 / side;
        if scale.is_finite() && scale > 0.0 { Self { centre, scale } } else { Self { centre: [0.0; 3], scale: 1.0 } }
    }

    /// The positions in the unit box.
    pub fn apply(&self, out: &mut [f32], positions: &[f32]) {
        let coordinates = out.iter_mut().zip(positions).enumerate();
        coordinates.for_each(|(i, (out, x))| *out = (*x - self.centre[i % 3]) * self.scale);
    }
}

fn graph(widths: Widths) -> (Tape, Var, Var) {
    let mut tape = Tape::new();
    let backbone = Backbone::record(&mut tape, widths);
    let points = tape.input(CHUNK, 3);
    let q = backbone.unwrap(&mut tape, points);
    (tape, points, q)
}

/// Bytes that [`evaluate`] takes, for any number of points.
pub fn evaluate_need(widths: Widths) -> usize {
    let (tape, ..) = graph(widths);
    bytes_for::<f32>(tape.value_count()).saturating_add(tape.scratch_need::<f32>())
}

/// Writes Q (n, 2) of `positions` (n, 3) by trained `weights` ([`Widths::parameter_count`] values). Each point's UV
/// depends on that point alone, to the bit.
#[allow(clippy::too_many_arguments)]
pub fn evaluate(
    q: &mut [f32],
    weights: &[f32],
    widths: Widths,
    frame: &Frame,
    positions: &[f32],
    path: Path,
    workers: &dyn Workers,
    scratch: &mut Scratch,
) -> Result<(), ScratchTooSmall> {
    scratch.require(evaluate_need(widths))?;
    let (tape, points, result) = graph(widths);
    let mut inner = scratch.frame();
    let values = inner.take::<f32>(tape.value_count())?;
    values[..weights.len()].copy_from(weights);
    let mut parts = q.chunks_mut(2 * CHUNK);
    for positions in positions.chunks(3 * CHUNK) {
        let Some(q) = parts.next() else { break };
        frame.apply(&mut points.of_mut(values)[..positions.len()], positions);
        let scratch = inner.frame();
        tape.forward(&mut Replay { values, gradients: &mut [], indices: &mut [], scratch, path, workers }, 1)?;
        q.copy_from(&result.of(values)[..q.len()]);
    }
    Ok(())
}

/// Bytes that [`seam_scores`] takes.
pub fn seam_scores_need(vertices: usize) -> usize {
    bytes_for::<f32>(vertices.saturating_mul(6)).saturating_add(bytes_for::<u32>(vertices.saturating_mul(5) + 5))
}

/// Writes the seam score of each vertex of the map `q` (n, 2), from ring neighbours (n, 5); above 0.5 is a seam.
pub fn seam_scores(
    scores: &mut [f32],
    q: &[f32],
    ring: &[u32],
    workers: &dyn Workers,
    scratch: &mut Scratch,
) -> Result<(), ScratchTooSmall> {
    let mut tape = Tape::new();
    let count = scores.len();
    let (map, table) = (tape.input(count, 2), tape.table(count * SEAM_NEIGHBOURS));
    let normalised = tape.normalise(map);
    let reach = tape.reach(normalised, table);
    let seam = tape.seam(reach, normalised);
    let mut inner = scratch.frame();
    let values = inner.take::<f32>(tape.value_count())?;
    let indices = inner.take::<u32>(tape.index_count())?;
    map.of_mut(values).copy_from(q);
    table.of_mut(indices).copy_from(ring);
    let scratch = inner.frame();
    tape.forward(&mut Replay { values, gradients: &mut [], indices, scratch, path: Path::Plain, workers }, 1)?;
    scores.copy_from(seam.of(values));
    Ok(())
}
