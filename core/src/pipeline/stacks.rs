//! Copies laid over one another on purpose: the originals alone are cut, flattened and packed, and every copy takes the UVs of its
//! original, corner by corner. Mirror images then lie there mirrored.

use super::settings::{Settings, Stacking};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::charts::copies::Copies;
use crate::charts::pieces::Pieces;
use crate::finish::place::PlaceSummary;
use crate::mesh::view::NONE;
use crate::mesh::working::Working;
use crate::solve::bound::distortion;
use glam::DVec2;

/// Copies that are taken off before the search and laid on their originals at the end.
pub(super) struct Stacks<'a> {
    all: Pieces<'a>,
    copies: Copies<'a>, // none where nothing is stacked
    aside: DVec2,       // how far copies lie from their originals
}

impl<'a> Stacks<'a> {
    /// Leaves the originals alone in `pieces`, their UVs in `uv` and their marks in `kept`, if the settings say so; there are no `copies`
    /// then.
    pub fn take_off(
        pieces: &mut Pieces<'a>,
        copies: &mut Copies<'a>,
        uv: &mut [DVec2],
        kept: &mut [u8],
        settings: &Settings,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let aside = DVec2::new(settings.stack_offset.into(), 0.0);
        let (all, found) = (*pieces, *copies);
        if settings.stack == Stacking::Off || !found.are_any() {
            return Ok(Self { all, copies: Copies::default(), aside });
        }
        *copies = Copies::default();
        *pieces = all.only(|p| !found.is_copy(p), keep)?;
        let mut slot = 0;
        for (to, p) in (0..all.count()).filter(|p| !found.is_copy(*p)).enumerate() {
            kept[to] = kept[p];
            for from in all.corners(p) {
                uv[slot] = uv[from];
                slot += 1;
            }
        }
        Ok(Self { all, copies: found, aside })
    }

    /// Lays every copy on its original, in the user's corners and polygons, and says so in `done`; `uv` has an entry a corner of all
    /// pieces, which are not needed any more. Returns how many charts lie on others, and how many faces are flipped there.
    pub fn lay_on(
        &self,
        corner_uv: &mut [DVec2],
        polygon_chart: &mut [u32],
        done: &mut PlaceSummary,
        uv: &mut [DVec2],
        working: &Working,
        mut scratch: Scratch,
    ) -> Result<(usize, usize), ScratchTooSmall> {
        let Self { all, copies, aside } = self;
        if !copies.are_any() {
            return Ok((0, 0));
        }
        let packed = done.chart_count;
        let corner = |slot: usize| working.corner_source[all.source[slot] as usize] as usize;
        let polygon = |slot: usize| working.polygon[all.source[slot] as usize / 3] as usize;
        let own = scratch.take_filled::<u32>(packed, NONE)?; // the copy's chart for each of its original's
        for p in (0..all.count()).filter(|p| copies.is_copy(*p)) {
            own.fill(NONE);
            for slot in all.corners(p) {
                let from = copies.image(p, slot, all);
                corner_uv[corner(slot)] = corner_uv[corner(from)] + *aside;
                // A damaged polygon may be in several pieces, and have its last one's chart.
                let Some(number) = own.get_mut(polygon_chart[polygon(from)] as usize) else { continue };
                if *number == NONE {
                    *number = done.chart_count as u32;
                    done.chart_count += 1;
                }
                polygon_chart[polygon(slot)] = *number;
            }
        }
        let flipped = self.flipped(|slot| corner_uv[corner(slot)]);
        self.spread(uv);
        done.distortion = distortion(uv, all.rest());
        Ok((done.chart_count - packed, flipped))
    }

    /// From the UVs of the originals, one after the other, to those of all pieces, each as seen from the front.
    fn spread(&self, uv: &mut [DVec2]) {
        let Self { all, copies, .. } = self;
        let originals = (0..all.count()).filter(|p| !copies.is_copy(*p));
        let mut end: usize = originals.map(|p| all.corners(p).len()).sum();
        // No original has moved to the left of where it stands: from the last one on nothing is written over.
        for corners in (0..all.count()).rev().filter(|p| !copies.is_copy(*p)).map(|p| all.corners(p)) {
            for slot in corners.rev() {
                end -= 1;
                uv[slot] = uv[end];
            }
        }
        copies.spread_maps(uv, all);
    }

    /// Faces of copies that are flipped: they lie on two of their original, and those form no convex quad. `at` is the UV of a corner.
    fn flipped(&self, at: impl Fn(usize) -> DVec2) -> usize {
        let Self { all, copies, .. } = self;
        let faces = (0..all.count())
            .filter(|p| copies.is_copy(*p))
            .flat_map(|p| (all.corners(p).start / 3..all.corners(p).end / 3).map(move |f| (p, 3 * f)));
        let is_flipped = |(p, c): (usize, usize)| {
            let on = [0, 1, 2].map(|i| copies.image(p, c + i, all) / 3);
            let is_split = on[0] != on[1] || on[1] != on[2];
            let side = if copies.is_mirrored(p) { -1.0 } else { 1.0 };
            is_split && (at(c + 1) - at(c)).perp_dot(at(c + 2) - at(c)) * side <= 0.0
        };
        faces.filter(|at| is_flipped(*at)).count()
    }
}
