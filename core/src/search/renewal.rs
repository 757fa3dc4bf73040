//! Ruin and recreate: cuts in a ball are closed, and the search goes on from there.
//!
//! A search goes by chance where cuts cost about the same: what it finds lies within a tenth or two of what another would, and it never
//! moves a cut that it has made. So a trial closes all cuts in a random ball around a cut that costs much (Schrimpf, Schneider,
//! Stamm-Wilbrandt, Dueck, *Record breaking optimization results using the ruin and recreate principle*, 2000; after Shaw 1998), flattens
//! the charts there anew and searches on; it stays where the price is less. A trial begins where the last that stayed ended.
//! Guarantee: the price never rises with more trials of the same seed; the outcome is that of trials one after the other, whatever the
//! memory and the workers. Cost: each trial about as much as the search before it.

use super::budget::Budget;
use super::direct::{Trials, direct_need, search_again, search_anew, search_from};
use crate::base::pace::{Marks, NoMarks, StageError};
use crate::base::random::{hash, unit_f64};
use crate::base::real::sqrt;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::{Workers, for_each_chunk};
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::first::disks::disks_again;
use crate::first::facets::cut_around_openings;
use crate::first::halving::flatten_below;
use crate::mesh::view::{NONE, next};
use crate::plane::crowding::Crowd;
use crate::price::cost::{FILL_WORTH, FORBIDDEN};
use crate::solve::bound::distortion;
use core::cmp::Ordering::Less;
use core::sync::atomic::{AtomicBool, Ordering};
use glam::{DVec2, DVec3};

/// Trials of any search: with 24 of them 13 meshes are noticed as much as with 8 (docs/RESULTS.md).
const ANY: u32 = 8;
/// Trials in a row that find nothing better, after which there are no more than were asked for.
const IN_VAIN: u32 = 6;
/// What cuts may cost before any is closed again, over what those of the best cost: trials that cut more are given up.
const CEILING: f64 = 1.15;
/// Radius of a ball over the root of the area, on the mean; each has half to one and a half of it.
const RADIUS: f64 = 0.4;
/// Worth of fill in a price, over what a cut that fills the square may cost ([`FILL_WORTH`]): the formula that foretells fill errs by
/// more than trials differ in it. Noticed and fill on bench/, made/ and artists/ are 1.634 .723, .982 .709, .949 .765 with .25 and 1.560 .678, .923
/// .666, .851 .749 with 0.
const FILL_SHARE: f64 = 0.06;
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

/// Scratch bytes that [`renew`] takes with `beside` trials side by side.
pub fn renewals_need(faces: usize, vertices: usize, trials: Trials, beside: usize) -> usize {
    beside.min(BESIDE) * (direct_need(faces, vertices, trials) + renewal_need(faces))
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
        let missed = (distortion(uv, surface.rest) - budget.distortion).max(0.0);
        let charts = ChartList::new(surface, cut, &mut scratch)?;
        let mut crowd = Crowd::default();
        for k in 0..charts.count() {
            let faces = charts.faces_of(k);
            let area = faces.iter().map(|f| surface.rest[*f as usize].area).sum::<f64>();
            let Some(start) = surface.outer_open(cut, faces, uv) else { continue };
            crowd.add(area, || surface.border(cut, start).map(|c| uv[c as usize]));
        }
        let further = if budget.whole { FURTHER * charts.count() as f64 } else { 0.0 };
        let all = further + cuts / sqrt(area) - FILL_SHARE * FILL_WORTH * crowd.fill();
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
        let other = from_openings(uv, cut, surface, budget, scratch.frame(), workers, marks);
        unless_ended(other, marks)?;
    }
    renew(uv, cut, surface, budget, Trials::All, renewals, scratch, workers, marks)
}

/// Searches from cuts around the openings of flat faces, where there are some: puts the outcome in place where its price is less.
fn from_openings(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let best = Price::of(uv, cut, surface, &budget, scratch.frame())?;
    let (other_uv, other_cut) = (scratch.take::<DVec2>(uv.len())?, scratch.take::<u8>(cut.len())?);
    if !cut_around_openings(other_cut, surface, scratch.frame())? {
        return Ok(());
    }
    marks.mark(0)?;
    let budget = Budget { ends_early: false, ..budget };
    search_from(other_uv, other_cut, surface, budget, Trials::All, scratch.frame(), workers, marks)?;
    if Price::of(other_uv, other_cut, surface, &budget, scratch)?.is_less(&best) {
        uv.copy_from(other_uv);
        cut.copy_from(other_cut);
    }
    Ok(())
}

/// Nothing where `result` is that the search was told to end, which is no error where there are charts.
fn unless_ended<T>(result: Result<T, StageError>, marks: &mut dyn Marks) -> Result<Option<T>, StageError> {
    result.map(Some).or_else(|e| e.end(marks).map(|_| None))
}

/// Ruins and recreates the charts `renewals` times, and keeps what costs less. Told to end, it ends with the best so far, and answers false.
#[allow(clippy::too_many_arguments)]
pub fn renew(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    trials: Trials,
    renewals: Renewals,
    scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<bool, StageError> {
    let done = renew_all(uv, cut, surface, budget, trials, renewals, scratch, workers, marks);
    Ok(unless_ended(done, marks)?.is_some())
}

#[allow(clippy::too_many_arguments)]
fn renew_all(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    budget: Budget,
    trials: Trials,
    renewals: Renewals,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let (faces, vertices) = (surface.mesh.faces.len(), surface.mesh.positions.len());
    let one = renewals_need(faces, vertices, trials, 1);
    let beside = (scratch.remaining() / one.max(1)).clamp(1, BESIDE);
    let budget = Budget { ends_early: false, ..budget };
    let mut best = Price::of(uv, cut, surface, &budget, scratch.frame())?;
    let (mut number, mut marked, mut in_vain) = (0, 0, 0);
    while number < renewals.most && (in_vain < IN_VAIN || number < renewals.least) {
        if marked == number {
            marks.mark(ROUNDS * faces)?;
            marked += 1;
        }
        let alarms = [const { AtomicBool::new(false) }; BESIDE];
        let renewal = Renewal { surface, budget, trials, best };
        let last = renewals.most.min(number + beside as u32);
        let jobs = renewal.try_beside(number..last, uv, cut, &alarms, scratch.frame(), workers)?;
        for job in jobs {
            if marked == number {
                marks.mark(ROUNDS * faces)?;
                marked += 1;
            }
            number += 1;
            in_vain += 1;
            if let Some(price) = job.price? {
                uv.copy_from(job.uv);
                cut.copy_from(job.cut);
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
    trials: Trials,
    best: Price,
}

/// A trial.
struct RenewalJob<'j> {
    number: u32,
    uv: &'j mut [DVec2],
    cut: &'j mut [u8],
    scratch: Option<Scratch<'j>>,
    price: Result<Option<Price>, StageError>, // what it found, where that costs less
}

impl Renewal<'_> {
    /// Tries `numbers` side by side; trials after the first that stays may be broken off.
    fn try_beside<'j>(
        &self,
        numbers: core::ops::Range<u32>,
        uv: &[DVec2],
        cut: &[u8],
        alarms: &'j [AtomicBool; BESIDE],
        mut scratch: Scratch<'j>,
        workers: &dyn Workers,
    ) -> Result<heapless::Vec<RenewalJob<'j>, BESIDE>, ScratchTooSmall> {
        let mut jobs = heapless::Vec::new();
        let share = scratch.remaining() / numbers.len().max(1);
        for (number, alarm) in numbers.zip(alarms) {
            let mut own = scratch.split(share)?;
            let (uv, cut) = (own.take_unset::<DVec2>(uv.len())?, own.take_unset::<u8>(cut.len())?);
            let scratch = Some(own.also_under(alarm));
            jobs.put(RenewalJob { number, uv, cut, scratch, price: Ok(None) });
        }
        for_each_chunk(workers, &mut jobs, 1, &|i, jobs| {
            for job in jobs {
                job.uv.copy_from(uv);
                job.cut.copy_from(cut);
                job.price = job.run(self, workers);
                if job.price.is_ok_and(|price| price.is_some()) {
                    alarms[i + 1..].iter().for_each(|alarm| alarm.store(true, Ordering::Relaxed));
                }
            }
        });
        Ok(jobs)
    }
}

impl RenewalJob<'_> {
    /// The price of what it makes of the charts, where that is less.
    fn run(&mut self, renewal: &Renewal, workers: &dyn Workers) -> Result<Option<Price>, StageError> {
        let Renewal { surface, budget, trials, best } = *renewal;
        let Some(mut scratch) = self.scratch.take() else { return Ok(None) };
        scratch.look_up()?;
        let changed = scratch.take::<u8>(surface.mesh.faces.len())?;
        if !ruin(self.cut, changed, self.uv, surface, hash(budget.seed, 0xd4a4, u64::from(self.number))) {
            return Ok(None);
        }
        disks_again(self.cut, surface, scratch.frame())?;
        flatten_below(self.uv, self.cut, changed, f64::INFINITY, surface, scratch.frame(), workers)?;
        let ceiling = CEILING * best.cuts;
        search_again(self.uv, self.cut, surface, budget, trials, ceiling, scratch.frame(), workers, &mut NoMarks)?;
        let price = Price::of(self.uv, self.cut, surface, &budget, scratch)?;
        Ok(Some(price).filter(|price| price.is_less(&best)))
    }
}

/// Closes the cuts in a ball around one that is drawn by its cost, and marks the faces beside them; false where there are none to draw.
fn ruin(cut: &mut [u8], changed: &mut [u8], uv: &[DVec2], surface: &Surface, key: u64) -> bool {
    let may_close = |c: u32, cut: &[u8]| {
        cut[c as usize] != 0 && surface.twin[c as usize] != NONE && surface.cost[c as usize] < FORBIDDEN
    };
    let Some(centre) = dearest(cut, uv, surface, unit_f64(key, 0, 0), may_close) else { return false };
    let area: f64 = surface.rest.iter().map(|r| r.area).sum();
    let radius = RADIUS * sqrt(area) * (0.5 + unit_f64(key, 1, 0));
    for c in 0..cut.len() as u32 {
        let away = middle(c, surface) - centre;
        if may_close(c, cut) && away.dot(away) < radius * radius {
            surface.set_cut(cut, c, false);
            [c, surface.twin[c as usize]].iter().for_each(|c| changed[*c as usize / 3] = 1);
        }
    }
    true
}

/// The middle of the cut up to which `share` of the cost of all goes.
fn dearest(
    cut: &[u8],
    uv: &[DVec2],
    surface: &Surface,
    share: f64,
    may_close: impl Fn(u32, &[u8]) -> bool,
) -> Option<DVec3> {
    let all = || (0..cut.len() as u32).filter(|c| may_close(*c, cut) && surface.is_seen(uv, cut, *c));
    let cost = |c: &u32| surface.cost[*c as usize];
    let mut left = share * all().map(|c| cost(&c)).sum::<f64>();
    let found = all().find(|c| {
        left -= cost(c);
        left <= 0.0
    });
    found.or_else(|| all().last()).map(|c| middle(c, surface))
}

/// Middle of the edge of `c`.
fn middle(c: u32, surface: &Surface) -> DVec3 {
    (surface.mesh.position(c) + surface.mesh.position(next(c))) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::solve::energy::{MOLLIFY, Rest};
    use std::vec;
    use std::vec::Vec;

    /// A ball of 8 x 4^`splits` faces, with `costs` of its half-edges given their length.
    fn on_ball<T>(splits: u32, cost: impl Fn(u32, f64) -> f64, then: impl FnOnce(&Surface, Scratch) -> T) -> T {
        let axes = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
        let mut triangles: Vec<[DVec3; 3]> = (0..4)
            .flat_map(|i| [[axes[i], axes[(i + 1) % 4], DVec3::Z], [axes[(i + 1) % 4], axes[i], DVec3::NEG_Z]])
            .collect();
        for _ in 0..splits {
            let split = |t: &[DVec3; 3]| {
                let m = [0, 1, 2].map(|i| (t[i] + t[(i + 1) % 3]).normalize());
                [[t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m]
            };
            triangles = triangles.iter().flat_map(split).collect();
        }
        let mut positions: Vec<DVec3> = Vec::new();
        let mut number = |p: DVec3| match positions.iter().position(|q| q.distance(p) < 1e-9) {
            Some(v) => v as u32,
            None => {
                positions.push(p);
                positions.len() as u32 - 1
            }
        };
        let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut number)).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let (mut memory, mut twin) = (vec![0; 1 << 26], vec![0; 3 * faces.len()]);
        let mut keep = Scratch::new(&mut memory);
        twins(&mut twin, mesh, keep.frame()).unwrap();
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), MOLLIFY)).collect();
        let length = |c: u32| mesh.position(c).distance(mesh.position(next(c)));
        let costs: Vec<f64> = (0..twin.len() as u32).map(|c| cost(c.min(twin[c as usize]), length(c))).collect();
        let surface = Surface::new(mesh, &twin, &rest, &costs, &mut keep).unwrap();
        then(&surface, keep)
    }

    #[test]
    fn a_ruin_closes_what_is_near_a_cut_that_costs_and_nothing_that_is_forbidden() {
        let of = |c: u32, length: f64| if c.is_multiple_of(7) { f64::INFINITY } else { length };
        on_ball(3, of, |surface, _| {
            let count = surface.twin.len();
            let uv: Vec<DVec2> = (0..count).map(|c| DVec2::new(c as f64, 0.0)).collect();
            for seed in 0..8 {
                let (mut cut, mut changed) = (vec![1; count], vec![0; count / 3]);
                assert!(ruin(&mut cut, &mut changed, &uv, surface, hash(seed, 0, 0)));
                let closed: Vec<u32> = (0..count as u32).filter(|c| cut[*c as usize] == 0).collect();
                assert!(!closed.is_empty() && closed.len() < count);
                // A ball of the area 4 pi has a diameter of three radii of the largest ruin at the most.
                let widest = 3.0 * RADIUS * sqrt(surface.rest.iter().map(|r| r.area).sum::<f64>());
                for c in &closed {
                    assert!(surface.cost[*c as usize].is_finite() && changed[*c as usize / 3] == 1);
                    assert_eq!(cut[surface.twin[*c as usize] as usize], 0);
                    assert!(middle(*c, surface).distance(middle(closed[0], surface)) < widest);
                }
            }
            assert!(!ruin(&mut vec![0; count], &mut vec![0; count / 3], &uv, surface, 1));
        });
    }

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
                let part = frame.split(renewals_need(faces, vertices, Trials::All, beside)).unwrap();
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
