//! A learned map made valid: unfolded, its worst faces relaxed, led back to the map that it was learned of where nothing else helps.
//!
//! Around faces that are turned over or overlap, nodes move towards their places in the given map, all the way near the face and
//! less with every ring further off. Around faces that are strained beyond the cap, what surrounds them is relaxed by Newton's method,
//! with everything beyond held; all is relaxed by steps while the mean is above the bound. Each round takes in more rings; a chart that stays bad is given back whole. What is far from bad faces
//! does not move.
//! Guarantee: as valid as the given map. Cost: O(faces x rings), where faces are bad.

use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::charts::cut_mesh::CutMesh;
use crate::mesh::view::NONE;
use crate::search::split::self_overlaps;
use crate::solve::bound::{Strain, most_distorted};
use crate::solve::energy::Rest;
use crate::solve::piece::{Piece, Stop};
use crate::solve::relax::relax;
use glam::DVec2;

/// Rings of faces that each round takes in; after the last, whole charts are given back.
const RINGS: [u32; 7] = [2, 3, 5, 8, 12, 20, 32];
/// Of a node that the next ring has.
const NEXT: u32 = NONE - 1;
/// When what surrounds a strained face is at rest.
const STOP: Stop = Stop { steps: 10, tolerance: 1e-4 };

/// All charts, a step at a time, while the bound is missed on the mean.
const STEP: Stop = Stop { steps: 1, tolerance: 0.0 };

/// What is mended.
pub(super) struct Mending<'m> {
    pub charts: &'m CutMesh<'m>,
    /// Rest shape of each face of the surface, by a function since pieces have them in another order.
    pub rest: &'m dyn Fn(u32) -> Rest,
    /// What the faces that are not learned add to the mean.
    pub others: Strain,
    /// The valid map: UVs of all nodes.
    pub given: &'m [DVec2],
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub bound: f64,
    pub workers: &'m dyn Workers,
}

/// Mends `x`, UVs of all nodes.
pub(super) fn mend(x: &mut [DVec2], mending: &Mending, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let Mending { charts, given, .. } = *mending;
    let ring = scratch.take::<u32>(x.len())?;
    let is_bad = scratch.take::<u8>(charts.faces.len())?;
    for rings in RINGS {
        if mending.folded(is_bad, x) > 0 {
            spread(ring, is_bad, charts, rings);
            lead_back(x, given, ring, rings);
        } else if mending.strained(is_bad, x) > 0 {
            spread(ring, is_bad, charts, rings);
            mending.relax_near(x, ring, rings, STOP, scratch.frame())?;
        } else if mending.mean(x) > mending.bound {
            ring.fill(0);
            for _ in 0..STOP.steps {
                if mending.mean(x) > mending.bound {
                    mending.relax_near(x, ring, rings, STEP, scratch.frame())?;
                }
            }
            if mending.mean(x) > mending.bound {
                x.copy_from(given);
            }
        } else if mending.overlapping(is_bad, x, scratch.frame())? > 0 {
            spread(ring, is_bad, charts, rings);
            lead_back(x, given, ring, rings);
        } else {
            return Ok(());
        }
    }
    mending.folded(is_bad, x);
    mending.give_back(x, is_bad);
    mending.strained(is_bad, x);
    mending.give_back(x, is_bad);
    mending.overlapping(is_bad, x, scratch.frame())?;
    mending.give_back(x, is_bad);
    if mending.mean(x) > mending.bound {
        x.copy_from(given);
    }
    Ok(())
}

impl Mending<'_> {
    /// Marks the faces that are turned over; returns how many.
    fn folded(&self, is_bad: &mut [u8], x: &[DVec2]) -> usize {
        self.mark(is_bad, |rest, nodes| {
            let [c0, c1] = rest.jacobian(nodes.map(|n| x[n as usize]));
            let det = c0.perp_dot(c1);
            rest.area > 0.0 && !(det > 0.0 && det.is_finite())
        })
    }

    /// Marks the faces that are strained beyond the cap and beyond what they bear in the given map; returns how many.
    fn strained(&self, is_bad: &mut [u8], x: &[DVec2]) -> usize {
        let most = 4.0 * most_distorted(self.bound);
        self.mark(is_bad, |rest, nodes| {
            let allowed = most.max(rest.energy(nodes.map(|n| self.given[n as usize])));
            let energy = rest.energy(nodes.map(|n| x[n as usize]));
            rest.area > 0.0 && (energy > allowed || energy.is_nan())
        })
    }

    /// Mean symmetric Dirichlet energy over 4, after the best scale, of these faces and the others.
    fn mean(&self, x: &[DVec2]) -> f64 {
        let mut strain = self.others;
        for f in self.charts.faces {
            let rest = (self.rest)(*f);
            if rest.area > 0.0 {
                strain.add(&rest, self.charts.nodes_at(*f).map(|n| x[n as usize]));
            }
        }
        if strain.area > 0.0 { strain.mean() } else { 1.0 }
    }

    fn mark(&self, is_bad: &mut [u8], test: impl Fn(Rest, [u32; 3]) -> bool) -> usize {
        for (f, bad) in self.charts.faces.iter().zip(is_bad.iter_mut()) {
            *bad = u8::from(test((self.rest)(*f), self.charts.nodes_at(*f)));
        }
        is_bad.iter().filter(|bad| **bad != 0).count()
    }

    /// Marks the faces that overlap others of their chart; returns how many.
    fn overlapping(&self, is_bad: &mut [u8], x: &[DVec2], mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
        let charts = self.charts;
        let uv = scratch.take::<DVec2>(3 * charts.faces.len())?;
        let chart = scratch.take::<u32>(charts.faces.len())?;
        let partner = scratch.take::<u32>(charts.faces.len())?;
        for (uv, f) in uv.as_chunks_mut::<3>().0.iter_mut().zip(charts.faces) {
            *uv = charts.nodes_at(*f).map(|n| x[n as usize]);
        }
        for k in 0..charts.count() {
            chart[charts.face_start[k] as usize..charts.face_start[k + 1] as usize].fill(k as u32);
        }
        self_overlaps(partner, uv, chart, charts.count(), |_| true, scratch, self.workers)?;
        is_bad.iter_mut().zip(partner.iter()).for_each(|(bad, partner)| *bad = u8::from(*partner != NONE));
        Ok(is_bad.iter().filter(|bad| **bad != 0).count())
    }

    /// Relaxes the nodes within `rings`, unless a face among them is turned over.
    fn relax_near(
        &self,
        x: &mut [DVec2],
        ring: &[u32],
        rings: u32,
        stop: Stop,
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let is_free = |n: u32| ring[n as usize] <= rings;
        let near = || self.charts.faces.iter().filter(|f| self.charts.nodes_at(**f).into_iter().any(is_free));
        let local = scratch.take_filled::<u32>(x.len(), NONE)?;
        let (mut count, mut free) = (0, 0);
        for held in [false, true] {
            for n in near().flat_map(|f| self.charts.nodes_at(*f)).filter(|n| is_free(*n) != held) {
                let local = &mut local[n as usize];
                if *local == NONE {
                    *local = count;
                    count += 1;
                }
            }
            free = if held { free } else { count as usize };
        }
        let faces = near().count();
        let (triangles, rest) = (scratch.take::<[u32; 3]>(faces)?, scratch.take::<Rest>(faces)?);
        let at = scratch.take::<DVec2>(count as usize)?;
        for ((triangle, rest), f) in triangles.iter_mut().zip(rest.iter_mut()).zip(near()) {
            let nodes = self.charts.nodes_at(*f);
            (*triangle, *rest) = (nodes.map(|n| local[n as usize]), (self.rest)(*f));
            nodes.iter().zip(*triangle).for_each(|(n, i)| at[i as usize] = x[*n as usize]);
        }
        let piece = Piece { triangles, rest, free, at: &[], springs: &[], walls: &[] };
        relax(at, &piece, stop, scratch, self.workers)?;
        let moved = x.iter_mut().zip(local.iter()).filter(|(_, local)| **local != NONE);
        moved.for_each(|(x, local)| *x = at[*local as usize]);
        Ok(())
    }

    /// Gives back the charts that have bad faces.
    fn give_back(&self, x: &mut [DVec2], is_bad: &[u8]) {
        for k in 0..self.charts.count() {
            let faces = self.charts.face_start[k] as usize..self.charts.face_start[k + 1] as usize;
            if is_bad[faces].iter().any(|bad| *bad != 0) {
                let nodes = self.charts.nodes_of(k);
                x[nodes.clone()].copy_from(&self.given[nodes]);
            }
        }
    }
}

/// Finds how many rings of faces each node is from bad faces, up to `rings`.
fn spread(ring: &mut [u32], is_bad: &[u8], charts: &CutMesh, rings: u32) {
    ring.fill(NONE);
    let bad = charts.faces.iter().zip(is_bad).filter(|(_, bad)| **bad != 0);
    bad.for_each(|(f, _)| charts.nodes_at(*f).iter().for_each(|n| ring[*n as usize] = 0));
    for now in 0..rings {
        for f in charts.faces {
            let nodes = charts.nodes_at(*f);
            if nodes.iter().any(|n| ring[*n as usize] == now) {
                for n in nodes {
                    let ring = &mut ring[n as usize];
                    *ring = if *ring == NONE { NEXT } else { *ring };
                }
            }
        }
        ring.iter_mut().filter(|r| **r == NEXT).for_each(|r| *r = now + 1);
    }
}

/// Moves nodes within `rings` towards their `given` places: those of the first rings all the way.
fn lead_back(x: &mut [DVec2], given: &[DVec2], ring: &[u32], rings: u32) {
    for ((x, given), ring) in x.iter_mut().zip(given).zip(ring).filter(|(_, ring)| **ring <= rings) {
        let share = 1.5 * (1.0 - f64::from(*ring) / f64::from(rings + 1));
        *x = if share < 1.0 { *x + (*given - *x) * share } else { *given };
    }
}
