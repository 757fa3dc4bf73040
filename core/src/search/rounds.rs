//! The rounds of a search: cuts grow, charts are parted, glued and zipped, and what that changes is relaxed.
//!
//! From the least cuts, cuts grow along cheapest paths towards what is still too distorted (top-down, against OptCuts' and the
//! greedy gluing of many charts: Li et al. 2018). Each round opens its slits by a few Newton steps from the map before it, so no map is
//! ever flipped. Charts that overlap themselves are split where it costs least, bulky ones where it saves most of the square, small ones
//! are glued where they fit, and cuts that the bound does not need in the end are zipped again.
//! Guarantee: no flips; no overlap inside a chart but of one polygon.

use super::budget::Budget;
use super::compact::split_bulky;
use super::extend::extend;
use super::glue::{Limits, glue_small};
use super::goal::{Goal, Which};
use super::split::{Split, self_overlaps, split_overlaps};
use super::zip::zip;
use crate::base::pace::{Halt, Marks, StageError};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::patch::{SEEDS, relax_patch};
use crate::charts::surface::Surface;
use crate::charts::work::{Work, work_on};
use crate::first::disks::slit_holes;
use crate::first::halving::flatten_below;
use crate::mesh::view::NONE;
use crate::solve::bound::{distortion, energies, lie_flat, most_distorted, worst};
use crate::solve::energy::Rest;
use crate::solve::piece::Stop;
use glam::DVec2;

/// Distortion below the bound at which extension ends: it is left to gluing and to gathering.
const RESERVE: f64 = 1.5e-3;
/// The reserve is at most this share of what the bound allows: at 1.003, 0.1 makes as many seams and more distortion.
const RESERVE_SHARE: f64 = 0.3;
/// Share of what the bound allows to which gluing goes.
const GLUE_TO: f64 = 0.97;
/// Distortion below the bound to which zipping goes: as near as gluing at 1.025.
const ZIP_RESERVE: f64 = 7.5e-4;
/// It is at most this share of what the bound allows, for angles and areas at tight bounds.
const ZIP_RESERVE_SHARE: f64 = 0.27;
/// Share of what the bound allows that closing slits may take where all of it is spent.
const SLIT_SHARE: f64 = 0.1;
/// Most excess of a glued chart over what the bound allows on the mean.
const OWN_EXCESS: f64 = 12.0;
/// And its mean energy over 4, less 1, whatever the bound.
const MOST_EXCESS: f64 = 0.15;
/// Reweighted relaxations at the end, and the Newton steps of each.
const CONCENTRATIONS: usize = 2;
/// Excess energy, over its mean, from which gathering holds a face back again: without, single faces reach an energy of 40
/// times an isometry's at the bound 1.025.
const WORST: f64 = 10.0;
/// See [`CONCENTRATIONS`].
const GATHER_STOP: Stop = Stop { steps: 3, tolerance: 1e-5 };
/// Paths that a round of extension adds at the most: more where the distortion is above the goal by more than [`FAR`] times
/// what the goal allows, so that tight bounds are reached within the rounds. With three, 63 meshes are noticed .4 % more in 1.03 times the time.
const PATHS: usize = 2;
/// See [`PATHS`].
const PATHS_FAR: usize = 8;
/// See [`PATHS`].
const FAR: f64 = 5.0;
/// Rounds of extension at the most; each adds paths where the distortion is worst.
const ROUNDS: usize = 80;
/// Times that all charts are relaxed because nothing is left to cut, each followed by more extension where it helped.
const RELAXATIONS: usize = 8;
/// Newton steps of such a relaxation.
const FAR_STOP: Stop = Stop { steps: 60, tolerance: 1e-3 };
/// Below this share of the distortion before, such a relaxation has found charts that were far from rest.
const AT_REST: f64 = 0.99;
/// Rounds of cutting towards faces above the cap.
const CAP_ROUNDS: usize = 30;
/// Rounds of splitting bulky charts.
const COMPACTIONS: usize = 12;
/// Rounds of gluing, each followed by splitting what then overlaps.
const GLUINGS: usize = 2;
/// Rounds of splitting at the most.
const SPLITS: usize = 60;
/// Newton steps of a round: the map need not be at rest before the next cut is chosen.
const ROUND_STOP: Stop = Stop { steps: 5, tolerance: 1e-4 };
/// Between walls, which hold steps back: with 5 steps and three paths a round one chart a piece is noticed 16 % more on 33 meshes.
const WALLED_STOP: Stop = Stop { steps: 20, ..ROUND_STOP };

/// When a chart without distortion is at rest: an excess of 1e-17 of its area moves a point by less than a step of the grid.
const UNROLLED: Stop = Stop { steps: 12, tolerance: 1e-17 };

/// A surface on its way to an atlas.
pub struct Rounds<'s> {
    /// UV of each corner.
    pub uv: &'s mut [DVec2], // (3 f)
    /// Flag of each half-edge.
    pub cut: &'s mut [u8], // (3 f)
    /// What the last step has touched.
    pub changed: &'s mut [u8], // (f)
    /// What is cut.
    pub surface: &'s Surface<'s>,
    /// What cuts may cost before any is closed again.
    pub ceiling: f64,
    /// Who works.
    pub workers: &'s dyn Workers,
    /// UVs and cuts at the last mark, where the search may be told to end.
    pub last: Option<(&'s mut [DVec2], &'s mut [u8])>,
    /// Passed between rounds.
    pub marks: &'s mut dyn Marks,
}

impl Rounds<'_> {
    /// Does `work`. Where that is told to end early, the maps are those of the last mark.
    pub fn to_the_end(&mut self, work: impl FnOnce(&mut Self) -> Result<(), StageError>) -> Result<(), StageError> {
        let Err(e) = work(self) else { return Ok(()) };
        let Some((uv, cut)) = &self.last else { return Err(e) };
        if e.end(self.marks)? == Halt::Back {
            self.uv.copy_from(uv);
            self.cut.copy_from(cut);
        }
        Ok(())
    }

    /// A mark: from here the search goes on, or ends.
    pub fn mark(&mut self) -> Result<(), StageError> {
        pass(self.marks, &mut self.last, self.uv, self.cut)
    }

    /// Cuts by `split`, which answers how much it found to do, and relaxes what that changed, until it finds nothing.
    fn repeat(
        &mut self,
        rounds: usize,
        split: impl Fn(&mut [u8], &mut [u8], &[DVec2], &Surface, Scratch) -> Result<usize, ScratchTooSmall>,
        mut scratch: Scratch,
    ) -> Result<(), StageError> {
        for _ in 0..rounds {
            self.mark()?;
            self.changed.fill(0);
            if split(self.cut, self.changed, self.uv, self.surface, scratch.frame())? == 0 {
                break;
            }
            self.relax_round(scratch.frame())?;
        }
        Ok(())
    }

    /// Cuts on until the distortion leaves no more than a reserve of what `bound` allows.
    pub fn extend(&mut self, bound: f64, mut scratch: Scratch) -> Result<(), StageError> {
        let goal = bound - RESERVE.min(RESERVE_SHARE * (bound - 1.0));
        let (workers, ceiling) = (self.workers, self.ceiling);
        let step = |cut: &mut [u8], changed: &mut [u8], uv: &[DVec2], surface: &Surface, scratch: Scratch| {
            let now = distortion(uv, surface.rest);
            if now <= goal || is_dear(uv, cut, surface, ceiling) {
                return Ok(0);
            }
            let near = if surface.stays_whole { 1 } else { PATHS };
            let paths = if now - 1.0 > FAR * (goal - 1.0) { PATHS_FAR } else { near };
            extend(cut, changed, uv, surface, 4.0, paths, scratch, workers)
        };
        for _ in 0..RELAXATIONS {
            self.repeat(ROUNDS, step, scratch.frame())?;
            let now = self.distortion();
            if now <= goal || self.is_dear() {
                break;
            }
            // Nothing is left to cut: what is distorted may only be far from rest.
            self.changed.fill(1);
            self.relax(FAR_STOP, self.surface.rest, scratch.frame())?;
            if self.distortion() > AT_REST * now {
                break;
            }
        }
        Ok(())
    }

    /// Splits charts until none overlaps itself.
    pub fn part_overlaps(&mut self, scratch: Scratch) -> Result<(), StageError> {
        self.changed.fill(1);
        self.part_changed(scratch)
    }

    /// The same for the charts with a changed face.
    fn part_changed(&mut self, mut scratch: Scratch) -> Result<(), StageError> {
        let mut has_cut_out = false;
        for round in 0.. {
            let how = if round < SPLITS { Split::Cheapest } else { Split::Halves };
            let mut found = self.split(how, scratch.frame())?;
            if found > 0 && !self.changed.contains(&1) && !has_cut_out {
                // No path parts them, as between a lid of one polygon and what lies on it.
                has_cut_out = true;
                self.changed.fill(1);
                found = self.split(Split::Islands, scratch.frame())?;
            }
            // What is left are polygons that overlap themselves.
            if found == 0 || !self.changed.contains(&1) {
                break;
            }
            self.relax_round(scratch.frame())?;
        }
        Ok(())
    }

    /// Passes a mark and parts the charts with a changed face that overlap themselves once; returns how many faces overlapped before.
    fn split(&mut self, how: Split, scratch: Scratch) -> Result<usize, StageError> {
        self.mark()?;
        let Self { uv, cut, changed, surface, workers, .. } = self;
        Ok(split_overlaps(cut, changed, uv, surface, how, scratch, *workers)?)
    }

    /// Splits charts until none is bulky or overlaps itself.
    pub fn part_bulky(&mut self, mut scratch: Scratch) -> Result<(), StageError> {
        self.repeat(COMPACTIONS, split_bulky, scratch.frame())?;
        self.part_overlaps(scratch)
    }

    /// Glues small charts to neighbours as far as the budget allows.
    pub fn glue(&mut self, budget: Budget, mut scratch: Scratch) -> Result<(), StageError> {
        for _ in 0..GLUINGS {
            if self.glue_once(budget, scratch.frame())? == 0 {
                break;
            }
            self.relax_round(scratch.frame())?;
            self.part_overlaps(scratch.frame())?;
        }
        Ok(())
    }

    /// Glues small charts to neighbours, which stay as they are; returns how many.
    pub fn glue_once(&mut self, budget: Budget, scratch: Scratch) -> Result<usize, StageError> {
        let area: f64 = self.surface.rest.iter().map(|r| r.area).sum();
        let bound = budget.distortion;
        let spare = 4.0 * area * (1.0 + GLUE_TO * (bound - 1.0) - self.distortion());
        let own = 4.0 + 4.0 * (OWN_EXCESS * (bound - 1.0)).min(MOST_EXCESS);
        let limits = Limits { spare, own, worst: 4.0 * most_distorted(bound), one: budget.bulky };
        self.changed.fill(0);
        Ok(glue_small(self.uv, self.cut, self.changed, self.surface, limits, scratch)?)
    }

    /// Brings single faces below the cap, whatever the mean: relaxes around them, and cuts on towards those that stay above.
    pub fn cap(&mut self, bound: f64, mut scratch: Scratch) -> Result<(), StageError> {
        let most = 4.0 * most_distorted(bound);
        if worst(self.uv, self.surface.rest) <= most {
            return Ok(());
        }
        for round in 0..CAP_ROUNDS {
            self.mark()?;
            self.changed.fill(0);
            if round > 0 && self.extend_above(most, scratch.frame())? == 0 {
                break;
            }
            let above = energies(self.uv, self.surface.rest).filter(|(_, energy)| *energy > most);
            above.for_each(|(f, _)| self.changed[f] = 1);
            self.relax_near(scratch.frame())?;
            if worst(self.uv, self.surface.rest) <= most {
                break;
            }
        }
        self.end_above(most, scratch.frame())?;
        self.part_overlaps(scratch)
    }

    /// Cuts towards the faces above `most`; returns how many paths.
    fn extend_above(&mut self, most: f64, scratch: Scratch) -> Result<usize, ScratchTooSmall> {
        let Self { uv, cut, changed, surface, workers, .. } = self;
        extend(cut, changed, uv, surface, most, PATHS_FAR, scratch, *workers)
    }

    /// Flattens the charts anew that have faces above `most` whatever was cut, and halves those that have them even so: a
    /// map can be stuck far from where it would be at rest.
    fn end_above(&mut self, most: f64, mut scratch: Scratch) -> Result<(), StageError> {
        self.changed.fill(0);
        energies(self.uv, self.surface.rest).filter(|(_, e)| *e > most).for_each(|(f, _)| self.changed[f] = 1);
        if self.changed.contains(&1) {
            let Self { uv, cut, changed, surface, workers, .. } = self;
            slit_holes(cut, surface, scratch.frame())?;
            flatten_below(uv, cut, changed, most, surface, scratch.frame(), *workers)?;
        }
        Ok(())
    }

    /// Takes out cuts that the bound does not need.
    pub fn zip(&mut self, budget: Budget, which: Which, scratch: Scratch) -> Result<(), StageError> {
        let bound = budget.distortion;
        let distortion = zip_to(which, self.distortion(), bound);
        let goal = Goal {
            distortion,
            worst: 4.0 * most_distorted(bound),
            bulky: budget.bulky || which == Which::Slivers,
            which,
        };
        let Self { uv, cut, last, surface, workers, marks, .. } = self;
        zip(uv, cut, surface, goal, scratch, *workers, &mut |uv, cut| pass(*marks, last, uv, cut))?;
        Ok(())
    }

    /// Relaxes all charts with less weight where distortion is large anyway, so that it gathers in few faces and most have
    /// little: the mean of its absolute values falls, that of its squares rises a bit. Where the bound breaks by that, it
    /// is undone by relaxing with the old weights; a chart that overlaps itself by it has its map of before back.
    pub fn concentrate(&mut self, bound: f64, mut scratch: Scratch) -> Result<(), StageError> {
        if self.distortion() > bound {
            return Ok(());
        }
        let before = scratch.take::<DVec2>(self.uv.len())?;
        before.copy_from(self.uv);
        {
            let mut frame = scratch.frame();
            let rest = frame.take::<Rest>(self.surface.rest.len())?;
            self.changed.fill(1);
            for _ in 0..CONCENTRATIONS {
                self.mark()?;
                rest.copy_from(self.surface.rest);
                gather(rest, self.uv);
                self.relax(GATHER_STOP, rest, frame.frame())?;
            }
        }
        if self.distortion() > bound {
            self.relax_round(scratch.frame())?;
        }
        self.take_back(before, scratch.frame())?;
        self.part_changed(scratch)
    }

    /// Gives the charts that overlap themselves their maps of `before`; they alone are marked as changed.
    fn take_back(&mut self, before: &[DVec2], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
        let Self { uv, cut, changed, surface, workers, .. } = self;
        let charts = ChartList::new(surface, cut, &mut scratch)?;
        let partner = scratch.take::<u32>(changed.len())?;
        let overlaps = scratch.take::<u8>(charts.count())?;
        self_overlaps(partner, uv, charts.of_face, charts.count(), |_| true, scratch, *workers)?;
        for (k, _) in charts.of_face.iter().zip(partner.iter()).filter(|(_, met)| **met != NONE) {
            overlaps[*k as usize] = 1;
        }
        changed.iter_mut().zip(charts.of_face).for_each(|(c, k)| *c = overlaps[*k as usize]);
        for c in (0..uv.len()).filter(|c| changed[c / 3] != 0) {
            uv[c] = before[c];
        }
        Ok(())
    }

    /// Brings charts without distortion to rest, where the sides of a slit that nothing holds open lie on each other.
    pub fn unroll(&mut self, mut scratch: Scratch) -> Result<(), StageError> {
        self.mark()?;
        {
            let Self { uv, cut, changed, surface, .. } = self;
            let mut frame = scratch.frame();
            let charts = ChartList::new(surface, cut, &mut frame)?;
            changed.fill(0);
            for faces in (0..charts.count()).map(|k| charts.faces_of(k)).filter(|f| lie_flat(f, uv, surface.rest)) {
                faces.iter().for_each(|f| changed[*f as usize] = 1);
            }
        }
        Ok(self.relax(UNROLLED, self.surface.rest, scratch)?)
    }

    /// Relaxes the charts that hold a changed face, for these rest shapes and weights.
    fn relax(&mut self, stop: Stop, rest: &[Rest], mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
        let Self { uv, cut, changed, surface, workers, .. } = self;
        let charts = ChartList::new(surface, cut, &mut scratch)?;
        let touched = |k: usize| charts.faces_of(k).iter().any(|f| changed[*f as usize] != 0);
        let weighed = Surface { rest, ..**surface };
        work_on(uv, &weighed, cut, &charts, touched, Work::Relax(stop), scratch, *workers)?;
        Ok(())
    }

    /// Relaxes the charts with a changed face as a round does.
    fn relax_round(&mut self, scratch: Scratch) -> Result<(), ScratchTooSmall> {
        let stop = if self.surface.stays_whole { WALLED_STOP } else { ROUND_STOP };
        self.relax(stop, self.surface.rest, scratch)
    }

    /// Relaxes what is around changed faces; whole charts where there are many or borders have walls.
    fn relax_near(&mut self, scratch: Scratch) -> Result<(), ScratchTooSmall> {
        let seeds = self.changed.iter().filter(|changed| **changed != 0).count();
        if self.surface.stays_whole || seeds > SEEDS {
            return self.relax_round(scratch);
        }
        relax_patch(self.uv, self.cut, self.changed, self.surface, ROUND_STOP, scratch, self.workers)
    }

    /// Whether cuts cost more than they may.
    pub fn is_dear(&self) -> bool {
        is_dear(self.uv, self.cut, self.surface, self.ceiling)
    }

    /// Mean symmetric Dirichlet energy over 4, after the best global scale.
    pub fn distortion(&self) -> f64 {
        distortion(self.uv, self.surface.rest)
    }
}

/// Whether cuts cost more than `ceiling`.
fn is_dear(uv: &[DVec2], cut: &[u8], surface: &Surface, ceiling: f64) -> bool {
    ceiling < f64::INFINITY && surface.cost_of(uv, cut) > ceiling
}

/// Passes a mark, and keeps what there is at it.
fn pass(
    marks: &mut dyn Marks,
    last: &mut Option<(&mut [DVec2], &mut [u8])>,
    uv: &[DVec2],
    cut: &[u8],
) -> Result<(), StageError> {
    let passed = marks.mark(uv.len() / 3);
    if let Some((last_uv, last_cut)) = last {
        last_uv.copy_from(uv);
        last_cut.copy_from(cut);
    }
    Ok(passed?)
}

/// The distortion to which zipping may go from the present one.
fn zip_to(which: Which, now: f64, bound: f64) -> f64 {
    match which {
        // What closes by itself costs nothing where the rest is above the bound anyway.
        Which::Slits if now > bound => now + SLIT_SHARE * (bound - 1.0),
        _ => bound - ZIP_RESERVE.min(ZIP_RESERVE_SHARE * (bound - 1.0)),
    }
}

/// Multiplies weights by (m / (m + e))^(1/2) (1 + e / (c m)), e the excess energy of each face and m its mean: one step of
/// reweighted least squares towards absolute values, which lets go of distorted faces, but not of the worst.
fn gather(rest: &mut [Rest], uv: &[DVec2]) {
    let excess = |f: usize, r: &Rest| r.energy([uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]]) - 4.0;
    let (mut sum, mut total) = (0.0, 0.0);
    for (f, r) in rest.iter().enumerate() {
        sum += r.weight * excess(f, r).min(1.0);
        total += r.weight;
    }
    let mean = (sum / total).max(1e-12);
    for (f, r) in rest.iter_mut().enumerate() {
        let times = (excess(f, r) / mean).clamp(0.0, 1000.0); // without end where a flat face is flipped
        r.weight *= (1.0 + times / WORST) / sqrt(1.0 + times);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;

    #[test]
    fn zipping_leaves_a_bound_that_holds() {
        for which in [Which::All, Which::Slivers, Which::Slits, Which::Ends] {
            for (now, bound) in [(1.0, 1.001), (1.02, 1.025), (1.0249, 1.025)] {
                assert!(zip_to(which, now, bound) < bound, "{which:?} from {now} at {bound}");
            }
        }
        assert_abs_diff_eq!(zip_to(Which::Slits, 1.3, 1.025), 1.3025, epsilon = 1e-12);
    }

    #[test]
    fn gathering_lets_go_of_distorted_faces_but_not_of_the_worst() {
        let at = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut rest = [Rest::new(at, 0.0); 3];
        let mut uv = [DVec2::ZERO; 9];
        for (f, scale) in [1.0, 1.2, 5.0].into_iter().enumerate() {
            for (i, p) in at.iter().enumerate() {
                uv[3 * f + i] = p.truncate() * scale;
            }
        }
        gather(&mut rest, &uv);
        // Excess energies 0, .27 and 46, capped mean .42: (1 + t / 10) / sqrt(1 + t) is 1, .83 and 1.13.
        let factor = |f: usize| rest[f].weight / 0.5;
        assert_abs_diff_eq!(factor(0), 1.0, epsilon = 1e-12);
        assert!(factor(1) < 0.9 && factor(2) > 1.1, "{} {}", factor(1), factor(2));
    }
}
