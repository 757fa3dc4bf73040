//! Ruin and recreate: cuts in a ball are closed, and the search goes on from there.
//!
//! A search goes by chance where cuts cost about the same: what it finds lies within a tenth or two of what another would, and it never
//! moves a cut that it has made. So a trial closes all cuts in a random ball around a cut that costs much (Schrimpf, Schneider,
//! Stamm-Wilbrandt, Dueck, *Record breaking optimization results using the ruin and recreate principle*, 2000; after Shaw 1998), flattens
//! the charts there anew and searches on; it stays where the price is less. A trial begins where the last that stayed ended.
//! Guarantee: the price never rises with more trials of the same seed; the outcome is that of trials one after the other, whatever the
//! memory and the workers. Cost: each trial about as much as the search before it.

use super::beside::try_beside;
use super::budget::Budget;
use super::direct::{Trials, direct_need, search_again, search_anew, search_from};
use super::ruin::{Ball, Draws};
use crate::base::pace::{Marks, NoMarks, StageError, unless_ended};
use crate::base::real::sqrt;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::first::disks::disks_again;
use crate::first::facets::cut_around_openings;
use crate::first::halving::flatten_below;
use crate::mesh::view::NONE;
use crate::plane::crowding::Crowd;
use crate::price::cost::{DISTORTION_WORTH, FILL_WORTH, IN_PLANE, SMOOTH};
use crate::price::turn::angle;
use crate::solve::bound::distortion;
use core::cmp::Ordering::Less;
use core::sync::atomic::AtomicBool;
use glam::DVec2;

/// Trials of any search. With 24 of them 63 meshes are noticed 2.5 % less than with 8, in 1.3 times the time (docs/RESULTS.md).
const ANY: u32 = 24;
/// Trials in a row that find nothing better, after which there are no more than were asked for. After 6, they are noticed 1.7 % less.
const IN_VAIN: u32 = 10;
/// What cuts may cost before any is closed again, over what those of the best cost: trials that cut more are given up. With 1.06
/// 72 meshes are noticed 1 % more, in the same time: others are tried instead.
const CEILING: f64 = 1.15;
/// Worth of fill in a price, over what a cut that fills the square may cost ([`FILL_WORTH`]): the formula that foretells fill errs by
/// more than trials differ in it. Noticed and fill on bench/, made/ and artists/ are 1.634 .723, .982 .709, .949 .765 with .25 and 1.560 .678, .923
/// .666, .851 .749 with 0.
const FILL_SHARE: f64 = 0.06;
/// Share of the bound's distortion in a search for next to none.
const STRICT: f64 = 0.04;
/// Price of a chart beyond the first where one is asked for: cuts over the root of the area cost up to thousands.
const FURTHER: f64 = 1e9;
/// Trials side by side at the most.
const BESIDE: usize = 2;
/// Rounds over the faces that a trial is counted as.
const ROUNDS: usize = 64;

/// How many trials there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Renewals {
    /// At the least.
    pub least: u32,
    /// At the most: those beyond the least end where they are in vain.
    pub most: u32,
}

impl Renewals {
    /// Those of any search, and `more`.
    pub fn with(more: u32) -> Self {
        Self { least: more, most: ANY + more }
    }

    /// So many.
    pub fn just(count: u32) -> Self {
        Self { least: count, most: count }
    }
}

/// Scratch bytes that one trial takes beyond a search.
const fn renewal_need(faces: usize) -> usize {
    bytes_for::<DVec2>(3 * faces) + bytes_for::<u8>(3 * faces) + bytes_for::<u8>(faces)
}

/// Scratch bytes of trials, `beside` of them side by side.
pub fn renewals_need(faces: usize, vertices: usize, beside: usize) -> usize {
    beside.min(BESIDE) * (direct_need(faces, vertices, Trials::All) + renewal_need(faces))
}

/// What charts cost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Price {
    missed: f64, // how far the distortion is above the bound
    cuts: f64,   // what cuts cost
    all: f64, // the same over the root of the area, and what is left empty of the square; where one chart is asked for, each further one costs more than all cuts
    charts: usize,
}

impl Price {
    fn of(
        uv: &[DVec2],
        cut: &[u8],
        surface: &Surface,
        budget: &Budget,
        mut scratch: Scratch,
    ) -> Result<Self, ScratchTooSmall> {
        let area: f64 = surface.rest.iter().map(|r| r.area).sum();
        let cuts = surface.cost_of(uv, cut);
        let distortion = distortion(uv, surface.rest);
        let missed = (distortion - budget.distortion).max(0.0);
        let charts = ChartList::new(surface, cut, &mut scratch)?;
        let mut crowd = Crowd::default();
        for k in 0..charts.count() {
            let faces = charts.faces_of(k);
            let area = faces.iter().map(|f| surface.rest[*f as usize].area).sum::<f64>();
            let Some(start) = surface.outer_open(cut, faces, uv) else { continue };
            crowd.add(area, || surface.border(cut, start).map(|c| uv[c as usize]));
        }
        let further = if budget.whole { FURTHER * charts.count() as f64 } else { 0.0 };
        let stretched = DISTORTION_WORTH * (distortion - 1.0);
        let all = further + cuts / sqrt(area) + stretched - FILL_SHARE * FILL_WORTH * crowd.fill();
        Ok(Self { missed, cuts, all, charts: charts.count() })
    }

    /// Whether it is less than another. More charts for fill alone are left to the cuts that let charts pack, which are tried by packing.
    fn is_less(&self, other: &Self) -> bool {
        let order = self.missed.total_cmp(&other.missed).then(self.all.total_cmp(&other.all));
        order == Less && (self.charts <= other.charts || self.missed < other.missed || self.cuts < other.cuts)
    }
}

/// Searches from the least cuts, and from cuts around the openings of flat faces where there are some; renews the better so many
/// times. Whether it was not told to end before.
#[allow(clippy::too_many_arguments)]
pub fn search_best(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    renewals: Renewals,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<bool, StageError> {
    search_anew(uv, cut, surface, budget, Trials::All, scratch.frame(), workers, marks)?;
    if !budget.whole {
        let other = from_others(uv, cut, surface, budget, scratch.frame(), workers, marks);
        unless_ended(other, marks)?;
    }
    let done = renew(uv, cut, surface, budget, renewals, scratch, workers, marks);
    Ok(unless_ended(done, marks)?.is_some())
}

/// Searches anew with next to no distortion where all is flat between sharp edges, which is to make no more charts, and from cuts around the openings of
/// flat faces where there are some: puts each outcome in place where its price is less.
fn from_others(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let mut best = Price::of(uv, cut, surface, &budget, scratch.frame())?;
    let (other_uv, other_cut) = (scratch.take::<DVec2>(uv.len())?, scratch.take::<u8>(cut.len())?);
    let budget = Budget { ends_early: false, ..budget };
    let strict = Budget { distortion: 1.0 + STRICT * (budget.distortion - 1.0), ..budget };
    if is_of_planes(surface) {
        marks.mark(0)?;
        search_anew(other_uv, other_cut, surface, strict, Trials::All, scratch.frame(), workers, marks)?;
        let price = Price::of(other_uv, other_cut, surface, &budget, scratch.frame())?;
        if price.charts <= best.charts && price.is_less(&best) {
            uv.copy_from(other_uv);
            cut.copy_from(other_cut);
            best = price;
        }
    }
    if cut_around_openings(other_cut, surface, scratch.frame())? {
        marks.mark(0)?;
        search_from(other_uv, other_cut, surface, budget, Trials::All, scratch.frame(), workers, marks)?;
        if Price::of(other_uv, other_cut, surface, &budget, scratch)?.is_less(&best) {
            uv.copy_from(other_uv);
            cut.copy_from(other_cut);
        }
    }
    Ok(())
}

/// Whether the surface is flat between sharp edges, all but a hundredth of the length of its edges.
fn is_of_planes(surface: &Surface) -> bool {
    let (mut all, mut bent) = (0.0, 0.0);
    for (c, t) in (0..).zip(surface.twin).filter(|(c, t)| **t != NONE && *c < **t) {
        let (turn, length) = (angle(surface.mesh, c, *t), surface.length(c));
        all += length;
        bent += if turn > IN_PLANE && turn < SMOOTH { length } else { 0.0 };
    }
    bent <= 0.01 * all
}

/// Ruins and recreates the charts `renewals` times, and keeps what costs less. Told to end, it leaves the best so far.
#[allow(clippy::too_many_arguments)]
fn renew(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    renewals: Renewals,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let (faces, vertices) = (surface.mesh.faces.len(), surface.mesh.positions.len());
    let one = renewals_need(faces, vertices, 1);
    let beside = (scratch.remaining() / one.max(1)).clamp(1, BESIDE);
    let budget = Budget { ends_early: false, ..budget };
    let mut best = Price::of(uv, cut, surface, &budget, scratch.frame())?;
    let (mut number, mut marked, mut in_vain) = (0, 0, 0);
    let mut draws = Draws::default();
    while number < renewals.most && (in_vain < IN_VAIN || number < renewals.least) {
        if marked == number {
            marks.mark(ROUNDS * faces)?;
            marked += 1;
        }
        let alarms = [const { AtomicBool::new(false) }; BESIDE];
        let renewal = Renewal { surface, budget, best };
        let mut balls = heapless::Vec::<_, BESIDE>::new();
        while balls.len() < beside.min((renewals.most - number) as usize)
            && let Some(ball) = draws.next(uv, cut, surface, budget.seed)
        {
            balls.put(ball);
        }
        if balls.is_empty() {
            break;
        }
        let run = |ball: &Ball, own_uv: &mut [DVec2], own_cut: &mut [u8], scratch: Scratch| {
            renewal.run(ball, own_uv, own_cut, cut, scratch, workers)
        };
        for job in try_beside(balls.into_iter(), uv, cut, &alarms, scratch.frame(), workers, &run)? {
            if marked == number {
                marks.mark(ROUNDS * faces)?;
                marked += 1;
            }
            number += 1;
            in_vain += 1;
            if let Some(price) = job.found? {
                uv.copy_from(job.uv);
                cut.copy_from(job.cut);
                draws = Draws::after(job.what);
                (best, in_vain) = (price, 0);
                break;
            }
        }
    }
    Ok(())
}

/// Charts, and what others have to cost less than.
struct Renewal<'r> {
    surface: &'r Surface<'r>,
    budget: Budget,
    best: Price,
}

impl Renewal<'_> {
    /// Closes the cuts of a ball and searches on; the price of what that makes of the charts, where it is less.
    fn run(
        &self,
        ball: &Ball,
        uv: &mut [DVec2],
        cut: &mut [u8],
        before: &[u8],
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<Option<Price>, StageError> {
        let Renewal { surface, budget, best } = *self;
        let changed = scratch.take::<u8>(surface.mesh.faces.len())?;
        for c in ball.cuts(before, surface) {
            surface.set_cut(cut, c, false);
            changed[c as usize / 3] = 1;
        }
        disks_again(cut, surface, scratch.frame())?;
        if *cut == *before {
            return Ok(None);
        }
        flatten_below(uv, cut, changed, f64::INFINITY, surface, scratch.frame(), workers)?;
        let ceiling = CEILING * best.cuts;
        search_again(uv, cut, surface, budget, ceiling, scratch.frame(), workers, &mut NoMarks)?;
        let price = Price::of(uv, cut, surface, &budget, scratch)?;
        Ok(Some(price).filter(|price| price.is_less(&best)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use crate::base::workers::Serial;
    use crate::search::ruin::tests::on_ball;
    use std::vec;

    #[test]
    fn more_trials_never_cost_more_and_give_the_same_bits_in_any_memory() {
        let uneven = |c: u32, length: f64| length * (1.0 + unit_f64(5, 0, u64::from(c)));
        on_ball(3, uneven, |surface, mut scratch| {
            let budget =
                Budget { distortion: 1.05, bulky: false, whole: false, renewals: 0, seed: 1, ends_early: false };
            let mut best = |count: u32, beside: usize| {
                let (mut uv, mut cut) = (vec![DVec2::ZERO; surface.twin.len()], vec![0; surface.twin.len()]);
                let (faces, vertices) = (surface.mesh.faces.len(), surface.mesh.positions.len());
                let mut frame = scratch.frame();
                let part = frame.split(renewals_need(faces, vertices, beside)).unwrap();
                let renewals = Renewals::just(count);
                search_best(&mut uv, &mut cut, surface, budget, renewals, part, &Serial, &mut NoMarks).unwrap();
                (Price::of(&uv, &cut, surface, &budget, scratch.frame()).unwrap(), cut)
            };
            let prices = [0, 2, 9].map(|count| best(count, 2));
            assert!(prices.windows(2).all(|w| w[1].0.all <= w[0].0.all), "{:?}", prices.each_ref().map(|p| p.0));
            assert!(prices[2].0.is_less(&prices[0].0));
            assert!(best(9, 1) == prices[2]);
        });
    }
}
