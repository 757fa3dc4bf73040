//! Prices of pieces that are alike: what a cut costs is the mean over all of them, whose exposure differs.

use super::settings::{Settings, Stacking};
use super::stacks::Stacks;
use crate::base::real::for_cost;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::charts::copies::Copies;
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
    pub fn find(
        cost: &'a mut [f64],
        uv: &mut [DVec2],
        kept: &mut [u8],
        pieces: &Pieces<'a>,
        tolerance: f64,
        settings: &Settings,
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let mirrored = settings.stack == Stacking::Mirrored;
        let (mut pieces, mut copies) = price_alike(cost, kept, pieces, tolerance, mirrored, keep)?;
        let stacks = Stacks::take_off(&mut pieces, &mut copies, uv, kept, settings, keep)?;
        Ok(Self { pieces, copies, stacks })
    }
}

/// Finds copies among all pieces but what is `kept`, and marks them there; returns them and the pieces with their prices, which are
/// written to `cost` where some are alike.
fn price_alike<'c>(
    cost: &'c mut [f64],
    kept: &mut [u8],
    pieces: &Pieces<'c>,
    tolerance: f64,
    mirrored: bool,
    keep: &mut Scratch<'c>,
) -> Result<(Pieces<'c>, Copies<'c>), ScratchTooSmall> {
    let copies = Copies::find(pieces, kept, tolerance, mirrored, keep)?;
    if !copies.are_any() {
        return Ok((*pieces, copies));
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
    Ok((pieces.priced(cost), copies))
}
