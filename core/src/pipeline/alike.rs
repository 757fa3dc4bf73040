//! Prices of pieces that are alike: what a cut costs is the mean over all of them, whose exposure differs.

use crate::base::real::for_cost;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::charts::copies::Copies;
use crate::charts::pieces::Pieces;
use crate::price::cost::FORBIDDEN;

/// Finds copies among all pieces but what is `kept`, and marks them there; returns them and the pieces with their prices, which are
/// written to `cost` where some are alike.
pub(super) fn price_alike<'c>(
    cost: &'c mut [f64],
    kept: &mut [u8],
    pieces: &Pieces<'c>,
    tolerance: f64,
    keep: &mut Scratch<'c>,
) -> Result<(Pieces<'c>, Copies<'c>), ScratchTooSmall> {
    let copies = Copies::find(pieces, kept, tolerance, false, keep)?;
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
