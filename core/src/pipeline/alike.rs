//! Prices of pieces that are alike: what a cut costs is the mean over all of them, whose exposure differs.

use super::settings::{Settings, Stacking};
use super::stacks::Stacks;
use crate::base::real::for_cost;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::charts::congruence::Likeness;
use crate::charts::copies::{Copies, Who};
use crate::charts::pieces::Pieces;
use crate::price::cost::FORBIDDEN;
use glam::DVec2;

/// Pieces that are to be worked on, with their prices.
pub(super) struct Alike<'a> {
    /// The pieces: the originals alone where copies are stacked.
    pub pieces: Pieces<'a>,
    /// Copies among them, which take their originals' charts.
    pub copies: Copies<'a>,
    /// Copies that are laid on their originals at the end.
    pub stacks: Stacks<'a>,
}

impl<'a> Alike<'a> {
    /// Finds what is alike among all pieces but what is `kept`; what is worked on comes first in `uv` and `kept` then.
    /// `mirror` as for [`Copies::find`]; `same` tells whether corners at two places are one corner in the file.
    #[allow(clippy::too_many_arguments)]
    pub fn find(
        cost: &'a mut [f64],
        uv: &mut [DVec2],
        kept: &mut [u8],
        pieces: &Pieces<'a>,
        same: &dyn Fn(usize, usize) -> bool,
        tolerance: f64,
        mirror: &'a [u32],
        settings: &Settings,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let likeness = likeness(settings.stack, tolerance);
        let who = Who { kept, stacked: Some(same).filter(|_| settings.stack != Stacking::Off) };
        let mut copies = Copies::find(pieces, who, likeness, mirror, keep)?;
        let mut pieces = price_alike(cost, kept, pieces, copies, keep)?;
        let stacks = Stacks::take_off(&mut pieces, &mut copies, uv, kept, settings, keep)?;
        Ok(Self { pieces, copies, stacks })
    }
}

/// What counts as alike where it is stacked so. Each coordinate may be off by `tolerance`.
fn likeness(stack: Stacking, tolerance: f64) -> Likeness {
    match stack {
        Stacking::Off => Likeness::exact(tolerance),
        Stacking::Same | Stacking::Mirrored => Likeness::near(stack == Stacking::Mirrored),
    }
}

/// Marks copies as `kept`; returns the pieces with their prices, which are written to `cost` where some are alike.
fn price_alike<'c>(
    cost: &'c mut [f64],
    kept: &mut [u8],
    pieces: &Pieces<'c>,
    copies: Copies,
    keep: &mut Scratch<'c>,
) -> Result<Pieces<'c>, ScratchTooSmall> {
    if !copies.are_any() {
        return Ok(*pieces);
    }
    cost.copy_from(pieces.cost());
    // What is forbidden on one is forbidden on all.
    let mean = |sum: f64, count: f64| match sum < FORBIDDEN {
        true => for_cost(sum / count),
        false if sum.is_infinite() => sum,
        false => FORBIDDEN,
    };
    copies.share_cost(cost, pieces, keep.frame(), mean)?;
    kept.iter_mut().enumerate().for_each(|(p, kept)| *kept |= u8::from(copies.is_copy(p)));
    Ok(pieces.priced(cost))
}
