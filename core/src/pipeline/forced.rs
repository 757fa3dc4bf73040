//! What is cut before the search, whatever it costs.

use super::input::Input;
use super::settings::{Settings, Straighten};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::union_find::UnionFind;
use crate::charts::bands::part_bands;
use crate::charts::congruence::Likeness;
use crate::charts::halves::{Parting, part_halves};
use crate::charts::pieces::Pieces;
use crate::mesh::view::NONE;
use crate::mesh::working::{CLOSED, DIAGONAL, FORCED, Working};
use crate::price::given::{HardEdges, OnMesh};
use crate::solve::bound::Strain;
use crate::solve::energy::{MOLLIFY, Rest};
use glam::DVec2;

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
    /// UVs of the file's corners, whose borders and folds are.
    kept_uv: Option<&'f [DVec2]>, // (c), or fewer
    /// Bound on the mean symmetric Dirichlet energy over 4.
    bound: f64,
}

/// Least area of one side of a fold over that of the other: a fold has two halves, a fault a few faces.
const FOLD: f64 = 0.125;

impl<'f> Forcing<'f> {
    /// What `settings` and the caller of `input` ask for; `count` says whether breaks say anything.
    pub fn new(input: &Input<'f>, settings: &Settings, count: bool, planes: Option<Planes>) -> Self {
        let Input { parts, kept_uv, .. } = *input;
        let breaks = settings.hard_edges == HardEdges::Require;
        let strips = settings.straighten == Straighten::Strips;
        Self { parts, breaks, closed_breaks: count, strips, planes, kept_uv, bound: settings.distortion }
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
    if let Some(uv) = forcing.kept_uv {
        mark_folds(forced, working, uv, forcing.bound, keep.frame())?;
    }
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

/// Marks the edges along which the file's UVs are folded over: faces up on one side and down on the other, of like size and both within
/// the bound as they are. What has to be cut anew is no fold.
fn mark_folds(
    forced: &mut [u8],
    working: &Working,
    uv: &[DVec2],
    bound: f64,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let mesh = working.mesh();
    let uv_of = |face: u32| {
        let at = |i: u32| uv.get(working.corner_source[(3 * face + i) as usize] as usize).copied();
        [0, 1, 2].map(|i| at(i).unwrap_or(DVec2::NAN))
    };
    let side = |face: u32| {
        let [a, b, c] = uv_of(face);
        let area = (b - a).perp_dot(c - a);
        i8::from(area > 0.0) - i8::from(area < 0.0)
    };
    let sheet = scratch.take::<u32>(mesh.faces.len())?;
    let is_inner = |forced: &[u8], h: usize| working.twin[h] != NONE && forced[h] == 0;
    let mut sheets = UnionFind::new(sheet);
    for h in (0..forced.len()).filter(|h| is_inner(forced, *h)) {
        let [own, beyond] = [h as u32 / 3, working.twin[h] / 3];
        if side(own) * side(beyond) >= 0 || working.fixed[h] == DIAGONAL {
            sheets.union(own, beyond);
        }
    }
    let count = sheets.number();
    let sums = scratch.take::<[f64; 3]>(count)?;
    for (face, sheet) in (0..).zip(sheet.iter()) {
        let rest = Rest::new([0, 1, 2].map(|i| mesh.position(3 * face + i)), MOLLIFY);
        let mut strain = Strain::default();
        strain.add(&rest, uv_of(face));
        let sum = &mut sums[*sheet as usize];
        [strain.stretch, strain.shrink, strain.area].iter().zip(sum).for_each(|(x, sum)| *sum += x);
    }
    let sheet_at = |face: u32| sheet[face as usize] as usize;
    let is_within = |[stretch, shrink, area]: [f64; 3]| Strain { stretch, shrink, area }.mean() <= bound;
    for h in 0..forced.len() {
        if !is_inner(forced, h) || working.fixed[h] == DIAGONAL {
            continue;
        }
        let faces = [h as u32 / 3, working.twin[h] / 3];
        let [one, other] = faces.map(|face| sums[sheet_at(face)]);
        let is_fold = sheet_at(faces[0]) != sheet_at(faces[1]) && side(faces[0]) * side(faces[1]) < 0;
        if is_fold && one[2].min(other[2]) >= FOLD * one[2].max(other[2]) && is_within(one) && is_within(other) {
            forced[h] = 1;
        }
    }
    Ok(())
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
