//! Seam optimisation: one budget of distortion, spent where it hides most.
//!
//! A piece is cut on the mesh itself, or, where it has more than [`PROXY_FROM`] faces, by way of two decimated ones. Guarantee: no flips;
//! no overlap inside a chart but of one polygon.

use super::budget::Budget;
use super::by_proxy::{PROXY_FROM, cut_by_proxies, proxies_need};
use super::direct::{Trials, close_ends, direct_need, search_anew, search_from};
use super::draws::{draws_need, search_best};
use crate::base::pace::{Marks, StageError};
use crate::base::scratch::Scratch;
use crate::base::workers::Workers;
use crate::charts::surface::Surface;
use glam::DVec2;

/// Pieces of more faces have no trials of their own.
const LARGE: usize = 30_000;

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
    if faces > PROXY_FROM { direct.max(proxies_need(faces, vertices)) } else { direct + draws_need(faces) }
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
    if faces <= PROXY_FROM {
        search_best(uv, cut, surface, budget, scratch.frame(), workers, marks)?;
    } else {
        let has_cuts = cut_by_proxies(cut, surface, budget, scratch.frame(), workers, marks)?;
        let search = if has_cuts { search_from } else { search_anew };
        search(uv, cut, surface, budget, trials, scratch.frame(), workers, marks)?;
    }
    match trials {
        Trials::None => Ok(()),
        _ => close_ends(uv, cut, surface, budget, scratch, workers, marks),
    }
}
