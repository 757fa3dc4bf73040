//! The search on one mesh, from the cuts that it has.

use super::budget::Budget;
use super::compact::compact_need;
use super::glue::glue_need;
use super::goal::Which;
use super::rounds::Rounds;
use super::zip::zip_need;
use crate::base::pace::{Marks, StageError};
use crate::base::scratch::{Scratch, bytes_for};
use crate::base::workers::Workers;
use crate::charts::patch::patch_need;
use crate::charts::surface::Surface;
use crate::charts::work::job_need;
use crate::first::disks::{cut_to_disks, slit_holes};
use crate::first::halving::flatten_all;
use crate::plane::overlap::overlaps_need;
use crate::solve::energy::Rest;
use glam::DVec2;

/// Times that extension, splitting and gluing may begin again where they end above the bound.
const PASSES: usize = 3;

/// Which trials there are of taking out cuts; each flattens a chart anew, which takes seconds on large meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trials {
    /// Of all cuts, and bulky charts are split.
    All,
    /// Of those around slivers; the rest comes from a search that had all.
    Slivers,
    /// None: slivers are glued where they fit.
    None,
}

/// Scratch bytes that [`search_from`] asks for.
pub fn direct_need(faces: usize, vertices: usize, trials: Trials) -> usize {
    let corners = 3 * faces;
    let lists = bytes_for::<Rest>(faces) + bytes_for::<u8>(faces) + 3 * bytes_for::<u32>(faces + 2);
    let growing = 12 * bytes_for::<f64>(vertices) + 12 * bytes_for::<u32>(vertices) + bytes_for::<[u64; 2]>(corners);
    let splitting = 10 * bytes_for::<u32>(faces) + 12 * bytes_for::<u32>(corners) + 24 * faces + overlaps_need(faces);
    let jobs = 4 * bytes_for::<u32>(corners) + job_need(faces);
    let zipping = if trials != Trials::None { zip_need(faces, vertices) + splitting.max(jobs) } else { 0 };
    lists
        + growing
            .max(splitting)
            .max(zipping)
            .max(jobs + bytes_for::<DVec2>(corners))
            .max(glue_need(faces))
            .max(compact_need(faces))
            .max(patch_need(faces))
}

/// Cuts to disks, and searches from there.
#[allow(clippy::too_many_arguments)]
pub fn search_anew(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    trials: Trials,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    cut.fill(0);
    cut_to_disks(cut, &Surface { stays_whole: budget.whole, ..*surface }, scratch.frame())?;
    search_from(uv, cut, surface, budget, trials, scratch, workers, marks)
}

/// Flattens what is cut, cuts on until the bound holds, and takes out cuts that it does not need.
#[allow(clippy::too_many_arguments)]
pub fn search_from(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    trials: Trials,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let surface = &Surface { stays_whole: budget.whole, ..*surface };
    flatten_all(uv, cut, surface, scratch.frame(), workers)?;
    in_rounds(uv, cut, surface, budget, scratch, workers, marks, |rounds, mut scratch| {
        rounds.mark()?;
        if trials != Trials::None {
            rounds.zip(budget, Which::Slits, scratch.frame())?;
        }
        all_rounds(rounds, budget, trials, scratch)
    })
}

/// The same from maps that are there, whose slits were closed; given up where cuts cost more than `ceiling` before any is closed again.
#[allow(clippy::too_many_arguments)]
pub fn search_again(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    ceiling: f64,
    scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    in_rounds(uv, cut, surface, budget, scratch, workers, marks, |rounds, scratch| {
        rounds.ceiling = ceiling;
        all_rounds(rounds, budget, Trials::All, scratch)
    })
}

/// What is done once when no search follows: distortion gathers in few faces, slivers are joined, what is flat is unrolled, holes have slits,
/// and ends of slits close with what the bound leaves.
#[allow(clippy::too_many_arguments)]
pub fn settle(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    trials: Trials,
    scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    in_rounds(uv, cut, surface, budget, scratch, workers, marks, |rounds, scratch| {
        last_rounds(rounds, budget, trials, scratch)
    })
}

/// Does `work`, which may be told to end early.
#[allow(clippy::too_many_arguments)]
fn in_rounds(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
    work: impl FnOnce(&mut Rounds, Scratch) -> Result<(), StageError>,
) -> Result<(), StageError> {
    let surface = &Surface { stays_whole: budget.whole, ..*surface };
    let changed = scratch.take::<u8>(surface.mesh.faces.len())?;
    let last = match budget.ends_early {
        true => Some((scratch.take::<DVec2>(uv.len())?, scratch.take::<u8>(cut.len())?)),
        false => None,
    };
    let mut rounds = Rounds { uv, cut, changed, last, surface, ceiling: f64::INFINITY, workers, marks };
    rounds.to_the_end(|rounds| work(rounds, scratch))
}

fn all_rounds(rounds: &mut Rounds, budget: Budget, trials: Trials, mut scratch: Scratch) -> Result<(), StageError> {
    rounds.mark()?;
    let compact = trials == Trials::All && !budget.bulky;
    if compact {
        rounds.part_bulky(scratch.frame())?;
    }
    for _ in 0..PASSES {
        rounds.extend(budget.distortion, scratch.frame())?;
        rounds.part_overlaps(scratch.frame())?;
        if compact {
            rounds.part_bulky(scratch.frame())?;
        }
        if rounds.is_dear() {
            return Ok(());
        }
        rounds.glue(budget, scratch.frame())?;
        if rounds.distortion() <= budget.distortion {
            break;
        }
    }
    rounds.cap(budget.distortion, scratch.frame())?;
    if trials != Trials::None {
        rounds.zip(budget, Which::Slits, scratch.frame())?;
    }
    if trials == Trials::All {
        rounds.zip(budget, Which::All, scratch.frame())?;
        rounds.zip(budget, Which::Slivers, scratch.frame())?;
    }
    rounds.mark()
}

fn last_rounds(rounds: &mut Rounds, budget: Budget, trials: Trials, mut scratch: Scratch) -> Result<(), StageError> {
    rounds.mark()?;
    rounds.concentrate(budget.distortion, scratch.frame())?;
    rounds.cap(budget.distortion, scratch.frame())?;
    // Slivers that the last two have made.
    if trials != Trials::None {
        rounds.zip(budget, Which::Slivers, scratch.frame())?;
    } else {
        rounds.glue_once(budget, scratch.frame())?;
    }
    rounds.unroll(scratch.frame())?;
    // What reads charts after the search reads disks: holes have slits again, whose sides lie on each other.
    slit_holes(rounds.cut, rounds.surface, scratch.frame())?;
    rounds.mark()?;
    if trials == Trials::None {
        return Ok(());
    }
    rounds.zip(budget, Which::Ends, scratch)?;
    rounds.mark()
}
