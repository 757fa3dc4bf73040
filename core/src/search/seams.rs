//! Seam optimisation: one budget of distortion, spent where it hides most.
//!
//! A piece is cut on the mesh itself, or, where it has more than [`PROXY_FROM`] faces and may have several charts, by way of a decimated one. Guarantee: no flips;
//! no overlap inside a chart but of one polygon.

use super::budget::Budget;
use super::by_proxy::{PROXY_FROM, cut_by_proxy, proxy_need};
use super::direct::{Trials, direct_need, search_anew, search_from, settle};
use super::renewal::{Renewals, renewals_need, search_best};
use crate::base::pace::{Marks, StageError, unless_ended};
use crate::base::scratch::Scratch;
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::surface::Surface;
use glam::DVec2;

/// Pieces of more faces have no trials of their own.
const LARGE: usize = 30_000;
/// Pieces of no more faces have memory for one trial at a time.
const SMALL: usize = 1000;

fn trials(faces: usize) -> Trials {
    if faces <= PROXY_FROM {
        Trials::All
    } else if faces <= LARGE {
        Trials::Slivers
    } else {
        Trials::None
    }
}

/// Scratch bytes that [`make_charts`] asks for.
pub fn make_charts_need(faces: usize, vertices: usize) -> usize {
    let direct = direct_need(faces, vertices, trials(faces));
    let renewals = |beside: usize| renewals_need(faces, vertices, beside);
    let own = match faces {
        ..=SMALL => renewals(1),
        _ if faces <= PROXY_FROM => renewals(2),
        _ => proxy_need(faces, vertices),
    };
    direct.max(own)
}

/// Cuts and flattens the surface: writes `cut` (one flag a half-edge) and `uv` (one point a corner).
pub fn make_charts(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let faces = surface.mesh.faces.len();
    // On 100k faces one tight contact holds all nodes back in every step: minutes instead of seconds.
    let budget = Budget { whole: budget.whole && faces <= LARGE, ..budget };
    let trials = trials(faces);
    // One chart that is held apart from itself takes many times as long, and none was found better.
    let more = budget.renewals;
    let renewals = if budget.whole { Renewals::just(more) } else { Renewals::with(more) };
    // The cuts of a coarse mesh whose one chart presses against itself leave a finer one no room: seams were three times as long.
    if faces <= PROXY_FROM || budget.whole {
        search_best(uv, cut, surface, budget, renewals, scratch.frame(), workers, marks)?;
    } else {
        let is_carried = cut_by_proxy(cut, surface, budget, renewals, scratch.frame(), workers, marks)?;
        let search = if is_carried { search_on } else { search_anew };
        search(uv, cut, surface, budget, trials, scratch.frame(), workers, marks)?;
    }
    settle(uv, cut, surface, budget, trials, scratch, workers, marks)
}

/// Searches from the cuts that there are; told to end before there is a map of them, it makes that all the same.
#[allow(clippy::too_many_arguments)]
fn search_on(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    trials: Trials,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    if !budget.ends_early {
        return search_from(uv, cut, surface, budget, trials, scratch, workers, marks);
    }
    let begun = scratch.take::<u8>(cut.len())?;
    begun.copy_from(cut);
    let found = search_from(uv, cut, surface, budget, trials, scratch.frame(), workers, marks);
    if unless_ended(found, marks)?.is_none() {
        cut.copy_from(begun);
        search_from(uv, cut, surface, budget, trials, scratch.quiet(), workers, marks)?;
    }
    Ok(())
}
