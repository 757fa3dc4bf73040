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
    /// pieces, which are not needed any more.
    pub fn lay_on(
        &self,
        corner_uv: &mut [DVec2],
        polygon_chart: &mut [u32],
        done: &mut PlaceSummary,
        uv: &mut [DVec2],
        working: &Working,
        mut scratch: Scratch,
    ) -> Result<usize, ScratchTooSmall> {
        let Self { all, copies, aside } = self;
        if !copies.are_any() {
            return Ok(0);
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
        uv.iter_mut().enumerate().for_each(|(slot, uv)| *uv = corner_uv[corner(slot)]);
        done.distortion = distortion(uv, all.rest());
        Ok(done.chart_count - packed)
    }
}
