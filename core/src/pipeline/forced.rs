//! What is cut before the search, whatever it costs.

use super::settings::{Settings, Straighten};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::charts::bands::part_bands;
use crate::charts::congruence::Likeness;
use crate::charts::halves::{Parting, part_halves};
use crate::charts::pieces::Pieces;
use crate::mesh::view::NONE;
use crate::mesh::working::{CLOSED, FORCED, Working};
use crate::price::given::{HardEdges, OnMesh};

/// What is cut whatever it costs beside borders of kept UVs and what the caller wants cut.
pub(super) struct Forcing<'f> {
    /// Parts, whose borders are.
    parts: Option<&'f [u32]>, // (p) of the input
    /// Every break of the shading.
    breaks: bool,
    /// Breaks where a crack was closed.
    closed_breaks: bool,
    /// Borders of strips between sharp edges.
    strips: bool,
    /// Mirror planes.
    planes: Option<Planes>,
}

impl<'f> Forcing<'f> {
    /// What `settings` and the caller ask for; `count` says whether breaks say anything.
    pub fn new(parts: Option<&'f [u32]>, settings: &Settings, count: bool, planes: Option<Planes>) -> Self {
        let breaks = settings.hard_edges == HardEdges::Require;
        let strips = settings.straighten == Straighten::Strips;
        Self { parts, breaks, closed_breaks: count, strips, planes }
    }
}

/// Which mirror planes part a piece.
#[derive(Clone, Copy)]
pub(super) struct Planes {
    /// Those of what is so much alike mirrored.
    pub likeness: Likeness,
    /// Also where diagonals of quads differ.
    pub over_diagonals: bool,
}

/// What is there before the search.
pub(super) struct Layout<'k> {
    /// Their borders are the cuts that there are whatever they cost.
    pub pieces: Pieces<'k>,
    /// How many of these are closed cracks.
    pub closed_breaks: usize,
    /// The mirror image of each corner, where there are halves.
    pub mirror: &'k [u32], // (3 f), or empty
}

/// Lays out the pieces.
pub(super) fn lay_out<'k>(
    working: &Working,
    given: &OnMesh,
    forcing: Forcing,
    cost: &mut [f64],
    keep: &mut Scratch<'k>,
) -> Result<Layout<'k>, ScratchTooSmall> {
    let forced = keep.take::<u8>(working.twin.len())?;
    let closed_breaks = mark_forced(forced, working, given, &forcing);
    if forcing.strips {
        let mut frame = keep.frame();
        let whole = Pieces::new(working.mesh(), working.twin, forced, cost, &mut frame)?;
        mark_strips(forced, &whole, frame)?;
    }
    let mirror = keep.take::<u32>(if forcing.planes.is_some() { forced.len() } else { 0 })?;
    if let Some(Planes { likeness, over_diagonals }) = forcing.planes {
        let mut frame = keep.frame();
        let whole = Pieces::new(working.mesh(), working.twin, forced, cost, &mut frame)?;
        part_halves(Parting { forced, cost, mirror }, &whole, likeness, over_diagonals, frame)?;
    }
    let pieces = Pieces::new(working.mesh(), working.twin, forced, cost, keep)?;
    Ok(Layout { pieces, closed_breaks, mirror })
}

/// Marks the half-edges that are cut whatever it costs; returns how many edges are such as closed cracks.
fn mark_forced(forced: &mut [u8], working: &Working, given: &OnMesh, forcing: &Forcing) -> usize {
    let Forcing { parts, breaks, closed_breaks, .. } = *forcing;
    let part = |face: u32| parts.map(|p| p.get(working.polygon[face as usize] as usize).copied().unwrap_or(NONE));
    let mut closed = 0;
    for (h, (out, mark)) in forced.iter_mut().zip(working.fixed).enumerate() {
        let twin = working.twin[h];
        let is_closed = closed_breaks && *mark == CLOSED && given.broken(h as u32) > 0.0;
        let wanted = || given.is_cut(h as u32) || is_closed || breaks && given.broken(h as u32) > 0.0;
        *out = u8::from(*mark == FORCED || twin != NONE && (part(h as u32 / 3) != part(twin / 3) || wanted()));
        closed += usize::from(is_closed && (h as u32) < twin);
    }
    closed
}

/// Marks the borders of strips.
fn mark_strips(forced: &mut [u8], pieces: &Pieces, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    for p in 0..pieces.count() {
        let corners = pieces.corners(p);
        let mut frame = scratch.frame();
        let own = frame.take::<u8>(corners.len())?;
        part_bands(own, &pieces.bare_surface(p), frame)?;
        for (mark, from) in own.iter().zip(&pieces.source[corners]) {
            forced[*from as usize] |= *mark;
        }
    }
    Ok(())
}
