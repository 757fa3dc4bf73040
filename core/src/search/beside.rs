//! Trials side by side, each on maps of its own.
//!
//! The first that finds something, in their order, breaks off those after it, which nobody will ask for.
//! Guarantee: what is found up to there is that of trials one after the other, whatever the memory and the workers.

use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use core::sync::atomic::{AtomicBool, Ordering};
use glam::DVec2;

/// A trial that has run.
pub struct Tried<'j, T, R, E> {
    /// What was tried.
    pub what: T,
    /// The maps that it made.
    pub uv: &'j mut [DVec2],
    /// And the cuts.
    pub cut: &'j mut [u8],
    scratch: Option<Scratch<'j>>,
    /// What it found.
    pub found: Result<Option<R>, E>,
}

/// What is done with one, on copies of UVs and cuts.
pub type TryOne<'r, T, R, E> = dyn Fn(&T, &mut [DVec2], &mut [u8], Scratch) -> Result<Option<R>, E> + Sync + 'r;

/// Runs `run` for each of `whats` on copies of `uv` and `cut`; no more than there are `alarms`. Trials after the first that finds
/// something may have been broken off.
pub fn try_beside<'j, T: Send, R: Send, E: Send + From<ScratchTooSmall>, const N: usize>(
    whats: impl ExactSizeIterator<Item = T>,
    uv: &[DVec2],
    cut: &[u8],
    alarms: &'j [AtomicBool; N],
    mut scratch: Scratch<'j>,
    workers: &dyn Workers,
    run: &TryOne<T, R, E>,
) -> Result<heapless::Vec<Tried<'j, T, R, E>, N>, ScratchTooSmall> {
    let mut trials = heapless::Vec::new();
    let share = scratch.remaining() / whats.len().max(1);
    for (what, alarm) in whats.zip(alarms) {
        alarm.store(false, Ordering::Relaxed);
        let mut own = scratch.split(share)?;
        let (uv, cut) = (own.take_unset::<DVec2>(uv.len())?, own.take_unset::<u8>(cut.len())?);
        trials.put(Tried { what, uv, cut, scratch: Some(own.also_under(alarm)), found: Ok(None) });
    }
    for_each_chunk(workers, &mut trials, 1, &|i, trials| {
        for trial in trials {
            let Some(scratch) = trial.scratch.take() else { continue };
            trial.found = scratch.look_up().map_err(E::from).and_then(|()| {
                trial.uv.copy_from(uv);
                trial.cut.copy_from(cut);
                run(&trial.what, trial.uv, trial.cut, scratch)
            });
            if matches!(trial.found, Ok(Some(_))) {
                alarms[i + 1..].iter().for_each(|alarm| alarm.store(true, Ordering::Relaxed));
            }
        }
    });
    Ok(trials)
}
