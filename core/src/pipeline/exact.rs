//! The exact method: charts by the search, and what is done to them before they are packed.

use super::early::complete;
use super::pieces::unwrap_pieces;
use super::report::UnwrapError;
use crate::base::pace::{Pace, StageError};
use crate::base::progress::{Progress, Stage};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::Slices;
use crate::base::workers::Workers;
use crate::finish::packing_cuts::cut_to_pack;
use crate::finish::place::Placing;
use crate::finish::strips::straighten_strips;
use crate::search::budget::Budget;
use glam::DVec2;

/// What it works on.
pub(super) struct ExactRun<'e> {
    pub placing: &'e Placing<'e>,
    pub polishing: Polishing,
    pub budget: Budget,
    pub kept: &'e [u8], // pieces for which there is nothing to do
    pub workers: &'e dyn Workers,
}

impl ExactRun<'_> {
    /// Runs up to a limit of counted work; returns after how much of it the stage ended early.
    pub fn run_for(
        &self,
        most: u64,
        uv: &mut [DVec2],
        cut: &mut [u8],
        scratch: Scratch,
        progress: &mut dyn Progress,
    ) -> Result<Option<u64>, UnwrapError> {
        let mut pace = Pace::new(progress, Stage::Seams, most);
        self.run(uv, cut, scratch, &mut pace)?;
        Ok(pace.has_ended().then(|| pace.work()))
    }

    /// Makes charts of all pieces: `uv` and `cut` have one entry a corner, in the order of the pieces. Where the stage ends early, what is
    /// missing is made without a search.
    fn run(&self, uv: &mut [DVec2], cut: &mut [u8], mut scratch: Scratch, pace: &mut Pace) -> Result<(), UnwrapError> {
        let Self { placing, polishing, budget, kept, workers } = *self;
        let pieces = placing.pieces;
        let made = unwrap_pieces(uv, cut, kept, pieces, budget, scratch.frame(), workers, pace)?;
        if !pace.has_ended() {
            polishing.unless_broken(uv, cut, kept, placing, budget.ends_early, scratch.frame(), workers, pace)?;
        }
        if pace.has_ended() {
            complete(uv, cut, made, kept, pieces, scratch, workers)?;
            placing.copies.spread(uv, cut, pieces);
        }
        Ok(())
    }
}

/// What is done to charts after the search.
#[derive(Clone, Copy)]
pub(super) struct Polishing {
    /// Whether strips become rectangles.
    pub straightens: bool,
    /// Whether charts are cut where that fills the square.
    pub cuts: bool,
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub distortion: f64,
}

impl Polishing {
    /// Polishes all but what is `kept`; gives copies what their originals have.
    pub fn polish(
        &self,
        uv: &mut [DVec2],
        cut: &mut [u8],
        kept: &[u8],
        placing: &Placing,
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<(), ScratchTooSmall> {
        if self.straightens {
            straighten_strips(uv, cut, kept, placing.pieces, self.distortion, scratch.frame(), workers)?;
        }
        placing.copies.spread(uv, cut, placing.pieces);
        if self.cuts {
            cut_to_pack(uv, cut, placing, scratch, workers)?;
        }
        Ok(())
    }

    /// Polishes; where that is broken off, all is as it was.
    #[allow(clippy::too_many_arguments)]
    fn unless_broken(
        &self,
        uv: &mut [DVec2],
        cut: &mut [u8],
        kept: &[u8],
        placing: &Placing,
        ends_early: bool,
        scratch: Scratch,
        workers: &dyn Workers,
        pace: &mut Pace,
    ) -> Result<(), UnwrapError> {
        if !ends_early {
            return Ok(self.polish(uv, cut, kept, placing, scratch, workers)?);
        }
        let alarm = scratch.alarm();
        let mut quiet = scratch.quiet();
        let (last_uv, last_cut) = (quiet.take::<DVec2>(uv.len())?, quiet.take::<u8>(cut.len())?);
        last_uv.copy_from(uv);
        last_cut.copy_from(cut);
        if let Err(e) = self.polish(uv, cut, kept, placing, quiet.under(alarm), workers) {
            StageError::from(e).end(pace)?;
            uv.copy_from(last_uv);
            cut.copy_from(last_cut);
        }
        Ok(())
    }
}
