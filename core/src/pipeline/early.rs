//! A search for seams that ended early becomes an atlas all the same.
//!
//! Pieces that it had not reached are laid down as they are seen along the axes. Those, and the one it was at, may hold charts that
//! overlap themselves, which are split: where it costs least, or the smaller part of those that were not searched.

use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::charts::pieces::Pieces;
use crate::first::projection::project;
use crate::search::split::{Split, split_overlaps};
use glam::DVec2;

/// Rounds of splitting with care, and all rounds.
const CAREFUL: usize = 6;
/// See [`CAREFUL`].
const ROUNDS: usize = 30;

/// Completes `uv` and `cut`, in which the first `made` pieces have charts, and those marked in `kept`.
pub(super) fn complete(
    uv: &mut [DVec2],
    cut: &mut [u8],
    made: usize,
    kept: &[u8],
    pieces: &Pieces,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let is_kept = |p: usize| kept.get(p).is_some_and(|kept| *kept != 0);
    for p in (made.saturating_sub(1)..pieces.count()).filter(|p| !is_kept(*p)) {
        let corners = pieces.corners(p);
        let (uv, cut) = (&mut uv[corners.clone()], &mut cut[corners]);
        let mut frame = scratch.frame();
        let surface = pieces.surface(p, &mut frame)?;
        if p >= made {
            project(uv, cut, &surface, frame.frame())?;
        }
        let changed = frame.take_filled::<u8>(uv.len() / 3, 1)?;
        for round in 0..ROUNDS {
            let careful = if p < made { Split::Cheapest } else { Split::Islands };
            let how = if round < CAREFUL { careful } else { Split::Halves };
            let found = split_overlaps(cut, changed, uv, &surface, how, frame.frame(), workers)?;
            if found == 0 || !changed.contains(&1) {
                break;
            }
        }
    }
    Ok(())
}
