//! Charts of every piece: small pieces are worked on side by side, a large one has all workers to itself.
//!
//! Guarantee: what a piece becomes depends on no other piece, and on no number of threads.

use crate::base::pace::{Marks, NoMarks, Pace, StageError};
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::take_first;
use crate::base::workers::{Serial, Workers, for_each_chunk};
use crate::charts::pieces::Pieces;
use crate::charts::surface::surface_need;
use crate::first::disks::slit_holes;
use crate::search::budget::Budget;
use crate::search::seams::{make_charts, make_charts_need};
use glam::DVec2;

/// Pieces of at most this share of all faces that are worked on are worked on side by side.
const SMALL: usize = 8;
/// Pieces that are worked on at the same time.
const LANES: usize = 8;

/// Rounds over its faces that a small piece is counted as.
const WAVE_ROUNDS: usize = 64;

/// Scratch bytes that [`unwrap_pieces`] asks for.
pub fn unwrap_pieces_need(pieces: &Pieces) -> usize {
    (0..pieces.count()).map(|p| piece_need(pieces, p)).max().unwrap_or(0)
}

fn piece_need(pieces: &Pieces, p: usize) -> usize {
    let (faces, vertices) = (pieces.corners(p).len() / 3, pieces.vertex_count(p));
    surface_need(faces, vertices) + make_charts_need(faces, vertices)
}

/// One piece at work.
struct PieceJob<'j> {
    piece: usize,
    uv: &'j mut [DVec2],
    cut: &'j mut [u8],
    scratch: Option<Scratch<'j>>,
    result: Result<(), StageError>,
}

/// Makes charts of every piece: `uv` and `cut` have one entry a corner, in the order of the pieces. Pieces that are marked in
/// `kept` (one a piece; no entry: not marked) stay as they are. Returns how many pieces, from the first on, have charts: all, unless
/// the stage had to end early.
#[allow(clippy::too_many_arguments)]
pub fn unwrap_pieces(
    uv: &mut [DVec2],
    cut: &mut [u8],
    kept: &[u8],
    pieces: &Pieces,
    budget: Budget,
    scratch: Scratch,
    workers: &dyn Workers,
    pace: &mut Pace,
) -> Result<usize, StageError> {
    let mut made = 0;
    if let Err(e) = unwrap_in_turn(&mut made, uv, cut, kept, pieces, budget, scratch, workers, pace) {
        e.end(pace)?;
    }
    Ok(made)
}

#[allow(clippy::too_many_arguments)]
fn unwrap_in_turn(
    made: &mut usize, // pieces
    uv: &mut [DVec2],
    cut: &mut [u8],
    kept: &[u8],
    pieces: &Pieces,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    pace: &mut Pace,
) -> Result<(), StageError> {
    scratch.require(unwrap_pieces_need(pieces))?;
    let is_kept = |p: usize| kept.get(p).is_some_and(|kept| *kept != 0);
    let total: usize = (0..pieces.count()).filter(|p| !is_kept(*p)).map(|p| pieces.corners(p).len() / 3).sum();
    let mut p = 0;
    let in_wave = Budget { ends_early: false, ..budget };
    let mut work = 0;
    while p < pieces.count() {
        *made = p;
        pace.at(p, pieces.count());
        if is_kept(p) {
            p += 1;
            continue;
        }
        pace.mark(work)?;
        work = 0;
        let corners = pieces.corners(p);
        if SMALL * corners.len() / 3 > total {
            alone(uv, cut, pieces, p, budget, scratch.frame(), workers, pace)?;
            p += 1;
            continue;
        }
        let mut short = heapless::Vec::<usize, LANES>::new();
        {
            let mut wave = scratch.frame();
            let mut jobs = heapless::Vec::<PieceJob, LANES>::new();
            let first = corners.start;
            let (mut uv_left, mut cut_left) = (&mut uv[first..], &mut cut[first..]);
            while p < pieces.count() && !jobs.is_full() {
                let len = pieces.corners(p).len();
                let need = piece_need(pieces, p);
                if is_kept(p) || SMALL * len / 3 > total || (wave.remaining() < need && !jobs.is_empty()) {
                    break;
                }
                let (uv, cut) = (take_first(&mut uv_left, len), take_first(&mut cut_left, len));
                jobs.put(PieceJob { piece: p, uv, cut, scratch: Some(wave.split(need)?), result: Ok(()) });
                p += 1;
            }
            for_each_chunk(workers, &mut jobs, 1, &|_, job| job[0].run(pieces, in_wave));
            work = WAVE_ROUNDS * jobs.iter().map(|job| job.uv.len() / 3).sum::<usize>();
            for job in &jobs {
                match job.result {
                    Err(StageError::Scratch(_)) => short.put(job.piece),
                    result => result?,
                }
            }
        }
        // What a piece needs is an estimate: those that it leaves short have all memory to themselves.
        for p in short {
            alone(uv, cut, pieces, p, in_wave, scratch.frame(), workers, &mut NoMarks)?;
        }
    }
    *made = pieces.count();
    Ok(pace.mark(work)?)
}

/// Cuts from the holes of charts to their outer borders in the pieces that are `wanted`: what places charts knows disks. Both sides of such a
/// cut lie on each other.
pub fn slit_pieces(
    cut: &mut [u8],
    pieces: &Pieces,
    wanted: impl Fn(usize) -> bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    for p in (0..pieces.count()).filter(|p| wanted(*p)) {
        let mut frame = scratch.frame();
        let surface = pieces.surface(p, &mut frame)?;
        slit_holes(&mut cut[pieces.corners(p)], &surface, frame)?;
    }
    Ok(())
}

/// Makes charts of piece `p` with all memory and all workers.
#[allow(clippy::too_many_arguments)]
fn alone(
    uv: &mut [DVec2],
    cut: &mut [u8],
    pieces: &Pieces,
    p: usize,
    budget: Budget,
    mut scratch: Scratch,
    workers: &dyn Workers,
    marks: &mut dyn Marks,
) -> Result<(), StageError> {
    let corners = pieces.corners(p);
    let mut frame = scratch.frame();
    let surface = pieces.surface(p, &mut frame)?;
    make_charts(&mut uv[corners.clone()], &mut cut[corners], &surface, budget, frame, workers, marks)
}

impl PieceJob<'_> {
    fn run(&mut self, pieces: &Pieces, budget: Budget) {
        let Some(mut scratch) = self.scratch.take() else { return };
        self.result = (|| {
            let surface = pieces.surface(self.piece, &mut scratch)?;
            make_charts(self.uv, self.cut, &surface, budget, scratch, &Serial, &mut NoMarks)
        })();
    }
}
