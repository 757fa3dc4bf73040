//! Pieces of the same shape: the charts of the first serve them all.
//!
//! Pieces are sorted by what stays as it is where a piece is moved; those that may be alike are laid onto one another
//! (`congruence`). The first of each shape, in the order of the pieces, is the original, the others are its copies: a cut costs the
//! mean over all of them, and charts are made for the original alone.
//! Guarantee: a copy has its original's cuts and UVs, corner by corner; whatever is not surely alike stands for itself.
//! Cost: O(f log f); a piece is compared with [`TRIES`] shapes of its figures at the most.

use super::congruence::{Comparison, Invariants, Likeness, lay_onto, lay_onto_need};
use super::pieces::Pieces;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::{NONE, prev};
use glam::DVec2;

/// Shapes of the same figures that a piece is compared with.
const TRIES: usize = 8;
/// Places that are nearer than this share of the mesh are one: UVs have a grid that is no finer.
const FINEST: f64 = 1.0 / (1 << 24) as f64;

/// Which pieces are alike.
#[derive(Clone, Copy, Default)]
pub struct Copies<'a> {
    original: &'a [u32], // (pieces), or none: all stand for themselves
    image: &'a [u32],    // (3 f) corner of the original, in its piece
    mirrored: &'a [u8],  // (pieces)
}

/// Which pieces may have the charts of others.
#[derive(Clone, Copy)]
pub struct Who<'w> {
    /// Pieces whose maps are kept (one a piece; no entry: not kept). They stand for themselves, but where copies are stacked, as they then are
    /// as well: among themselves.
    pub kept: &'w [u8],
    /// Where copies are laid over their originals: whether two corners, by their places, are one corner in the file. A piece that has
    /// its original's corners all over stands for itself.
    pub stacked: Option<&'w dyn Fn(usize, usize) -> bool>,
}

impl Who<'_> {
    fn is_kept(&self, p: u32) -> bool {
        self.kept.get(p as usize).is_some_and(|kept| *kept != 0)
    }

    fn stands_alone(&self, p: u32) -> bool {
        self.is_kept(p) && self.stacked.is_none()
    }
}

/// Scratch bytes that [`Copies::find`] keeps.
pub const fn copies_keep(faces: usize) -> usize {
    bytes_for::<u32>(3 * faces) + 2 * bytes_for::<u32>(faces) + bytes_for::<u8>(faces)
}

/// Scratch bytes that [`Copies::find`] keeps or uses.
pub const fn copies_need(faces: usize) -> usize {
    copies_keep(faces)
        + 3 * bytes_for::<u32>(faces)
        + bytes_for::<Invariants>(faces)
        + 2 * bytes_for::<u32>(3 * faces)
        + lay_onto_need(faces, 3 * faces)
}

impl<'a> Copies<'a> {
    /// Finds them among the pieces that `who` tells of.
    /// `mirror` names the mirror image of each corner of the given mesh, or none: what is a mirror image of another piece is laid on it so.
    pub fn find(
        pieces: &Pieces,
        who: Who,
        likeness: Likeness,
        mirror: &[u32], // (3 f of the given mesh), or empty
        keep: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let count = pieces.count();
        if count < 2 {
            return Ok(Self::default());
        }
        let original = keep.take::<u32>(count)?;
        let image = keep.take::<u32>(pieces.source.len())?;
        let is_mirrored = keep.take::<u8>(count)?;
        let leader = keep.take::<u32>(count)?;
        let likeness = Likeness { tolerance: likeness.tolerance.max(FINEST), ..likeness };
        let mut gathering = Gathering { pieces, likeness, image, is_mirrored };
        {
            let mut frame = keep.frame();
            let halves = Halves::new(pieces, mirror, &mut frame)?;
            gathering.gather(leader, &halves, who, frame)?;
            gathering.unfold(leader, &halves);
        }
        gathering.begin_with_first(original, leader, who, keep.frame())?;
        if original.iter().zip(0..).all(|(o, p)| *o == p) {
            return Ok(Self::default());
        }
        Ok(Self { original, image: gathering.image, mirrored: gathering.is_mirrored })
    }

    /// The piece whose charts piece `p` has: itself, or one before it.
    pub fn original(&self, p: usize) -> usize {
        self.original.get(p).map_or(p, |o| *o as usize)
    }

    /// Whether piece `p` has the charts of another.
    pub fn is_copy(&self, p: usize) -> bool {
        self.original(p) != p
    }

    /// Whether any piece has.
    pub fn are_any(&self) -> bool {
        !self.original.is_empty()
    }

    /// How many of `pieces` pieces have the charts of each, itself among them; 0 of a copy.
    pub fn counts<'k>(&self, pieces: usize, keep: &mut Scratch<'k>) -> Result<&'k [u32], ScratchTooSmall> {
        let counts = keep.take::<u32>(pieces)?;
        (0..pieces).for_each(|p| counts[self.original(p)] += 1);
        Ok(counts)
    }

    /// Whether piece `p` is a mirror image of its original.
    pub fn is_mirrored(&self, p: usize) -> bool {
        self.mirrored.get(p).is_some_and(|m| *m != 0)
    }

    /// Place, in arrays over all corners, of the corner of the original on which the corner at place `slot`, of piece `p`, lies.
    pub fn image(&self, p: usize, slot: usize, pieces: &Pieces) -> usize {
        match self.is_copy(p) {
            true => pieces.corners(self.original(p)).start + self.image[slot] as usize,
            false => slot,
        }
    }

    /// The same of half-edges.
    pub fn half_edge(&self, p: usize, slot: usize, pieces: &Pieces) -> usize {
        match self.is_copy(p) {
            true => {
                let c = self.image[slot];
                let side = if self.is_mirrored(p) { prev(c) } else { c };
                pieces.corners(self.original(p)).start + side as usize
            }
            false => slot,
        }
    }

    /// Gives all copies and their original the mean of their costs, which `mean` makes of a sum and how many it is of. `cost` has one
    /// entry a half-edge, in the order of the pieces.
    pub fn share_cost(
        &self,
        cost: &mut [f64],
        pieces: &Pieces,
        mut scratch: Scratch,
        mean: impl Fn(f64, f64) -> f64,
    ) -> Result<(), ScratchTooSmall> {
        let times = self.counts(pieces.count(), &mut scratch)?;
        for p in (0..pieces.count()).filter(|p| self.is_copy(*p)) {
            for slot in pieces.corners(p) {
                let on = self.half_edge(p, slot, pieces);
                // A diagonal that only the copy has lies on no half-edge, and is never cut.
                cost[on] += if cost[slot].is_infinite() && cost[on].is_finite() { 0.0 } else { cost[slot] };
            }
        }
        for (p, times) in times.iter().enumerate().filter(|(_, times)| **times > 1) {
            pieces.corners(p).for_each(|slot| cost[slot] = mean(cost[slot], (*times).into()));
        }
        for p in (0..pieces.count()).filter(|p| self.is_copy(*p)) {
            pieces.corners(p).for_each(|slot| cost[slot] = cost[self.half_edge(p, slot, pieces)]);
        }
        Ok(())
    }

    /// Gives copies the cuts and UVs of their originals; those of mirrored ones are mirrored.
    pub fn spread(&self, uv: &mut [DVec2], cut: &mut [u8], pieces: &Pieces) {
        self.spread_maps(uv, pieces);
        self.spread_cuts(cut, pieces);
    }

    /// Gives copies the UVs of their originals; those of mirrored ones are mirrored.
    pub fn spread_maps(&self, uv: &mut [DVec2], pieces: &Pieces) {
        for p in (0..pieces.count()).filter(|p| self.is_copy(*p)) {
            let side = if self.is_mirrored(p) { DVec2::new(-1.0, 1.0) } else { DVec2::ONE };
            for slot in pieces.corners(p) {
                uv[slot] = uv[self.image(p, slot, pieces)] * side;
            }
        }
    }

    /// Gives copies the cuts of their originals.
    pub fn spread_cuts(&self, cut: &mut [u8], pieces: &Pieces) {
        for p in (0..pieces.count()).filter(|p| self.is_copy(*p)) {
            pieces.corners(p).for_each(|slot| cut[slot] = cut[self.half_edge(p, slot, pieces)]);
        }
    }
}

/// Pieces that are halves of one in its mirror plane.
struct Halves<'a> {
    mirror: &'a [u32],
    slot: &'a [u32],  // (3 f) place of each corner of the given mesh
    piece: &'a [u32], // (f) piece of each face, by its place
}

impl<'a> Halves<'a> {
    fn new<'k: 'a>(pieces: &Pieces, mirror: &'a [u32], keep: &mut Scratch<'k>) -> Result<Self, ScratchTooSmall> {
        let count = if mirror.is_empty() { 0 } else { pieces.source.len() };
        let (slot, piece) = (keep.take::<u32>(count)?, keep.take::<u32>(count / 3)?);
        if count > 0 {
            pieces.source.iter().zip(0..).for_each(|(source, at)| slot[*source as usize] = at);
            (0..pieces.count()).for_each(|p| {
                let corners = pieces.corners(p);
                piece[corners.start / 3..corners.end / 3].fill(p as u32);
            });
        }
        Ok(Self { mirror, slot, piece })
    }

    /// The half of which piece `p` is the mirror image, if that comes before it.
    fn first(&self, p: usize, pieces: &Pieces) -> Option<usize> {
        let first = self.piece.get(self.image(pieces.corners(p).start, pieces)? / 3)?;
        Some(*first as usize).filter(|first| *first < p)
    }

    /// Place of the mirror image of the corner at place `slot`, if it has one.
    fn image(&self, slot: usize, pieces: &Pieces) -> Option<usize> {
        self.slot.get(*self.mirror.get(pieces.source[slot] as usize)? as usize).map(|slot| *slot as usize)
    }
}

/// The search for what is alike.
struct Gathering<'s, 'a> {
    pieces: &'s Pieces<'s>,
    likeness: Likeness,
    image: &'a mut [u32],
    is_mirrored: &'a mut [u8],
}

impl Gathering<'_, '_> {
    /// Names for each piece one of its shape, the leader, onto which it is laid; but for other halves.
    fn gather(
        &mut self,
        leader: &mut [u32],
        halves: &Halves,
        who: Who,
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let count = leader.len();
        let figures = scratch.take::<Invariants>(count)?;
        figures.iter_mut().enumerate().for_each(|(p, f)| *f = Invariants::of(&self.pieces.bare_surface(p)));
        let order = scratch.take::<u32>(count)?;
        order.iter_mut().zip(0..).for_each(|(o, p)| *o = p);
        let of = |p: &u32| &figures[*p as usize];
        sort::by(order, |a, b| of(a).counts.cmp(&of(b).counts).then(of(a).area.total_cmp(&of(b).area)).then(a.cmp(b)));
        let leaders = scratch.take::<u32>(count)?;
        let mut known = 0;
        for p in order.iter().copied() {
            let slack = of(&p).slack(self.likeness);
            leader[p as usize] = p;
            self.lie_still(p as usize);
            if who.stands_alone(p) || halves.first(p as usize, self.pieces).is_some() {
                continue;
            }
            // The nearest areas come last.
            let near = leaders[..known]
                .iter()
                .rev()
                .take_while(|l| of(l).counts == of(&p).counts && of(&p).area - of(l).area <= slack * of(&p).length);
            for l in near.filter(|l| who.is_kept(**l) == who.is_kept(p)).take(TRIES) {
                if self.lay(p as usize, *l as usize, [of(&p), of(l)], slack, scratch.frame())? {
                    leader[p as usize] = *l;
                    break;
                }
            }
            if leader[p as usize] == p {
                self.lie_still(p as usize);
                leaders[known] = p;
                known += 1;
            }
        }
        Ok(())
    }

    /// Lays other halves on their first ones, and so on their leaders.
    fn unfold(&mut self, leader: &mut [u32], halves: &Halves) {
        for (p, first) in (0..leader.len()).filter_map(|p| Some((p, halves.first(p, self.pieces)?))) {
            leader[p] = leader[first];
            self.is_mirrored[p] = 1 ^ self.is_mirrored[first];
            for slot in self.pieces.corners(p) {
                let Some(on) = halves.image(slot, self.pieces) else { continue };
                self.image[slot] = self.image[on];
            }
        }
    }

    /// Lays piece `p` on itself.
    fn lie_still(&mut self, p: usize) {
        self.image[self.pieces.corners(p)].iter_mut().zip(0..).for_each(|(i, c)| *i = c);
        self.is_mirrored[p] = 0;
    }

    /// Lays piece `p` onto piece `l`; whether it is alike.
    fn lay(
        &mut self,
        p: usize,
        l: usize,
        figures: [&Invariants; 2],
        slack: f64,
        mut scratch: Scratch,
    ) -> Result<bool, ScratchTooSmall> {
        let (from, onto) = (self.pieces.bare_surface(p), self.pieces.bare_surface(l));
        for mirrored in [false, true].into_iter().take(1 + usize::from(self.likeness.mirrored)) {
            let pair = Comparison { from: &from, onto: &onto, figures, mirrored, slack, strain: self.likeness.strain };
            if lay_onto(&mut self.image[self.pieces.corners(p)], pair, scratch.frame())? {
                self.is_mirrored[p] = mirrored.into();
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Makes the first piece of each shape the original, and lays all others onto it in place of their leader.
    fn begin_with_first(
        &mut self,
        original: &mut [u32],
        leader: &[u32],
        who: Who,
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        let first = scratch.take_filled::<u32>(leader.len(), NONE)?;
        for (p, l) in leader.iter().enumerate() {
            let first = &mut first[*l as usize];
            *first = (*first).min(p as u32);
            original[p] = *first;
        }
        for (p, l) in leader.iter().enumerate() {
            let o = original[p] as usize;
            if o == p || o == *l as usize {
                continue;
            }
            // From the leader back to the original.
            let mut frame = scratch.frame();
            let back = frame.take::<u32>(self.pieces.corners(p).len())?;
            self.image[self.pieces.corners(o)].iter().zip(0..).for_each(|(i, c)| back[*i as usize] = c);
            self.image[self.pieces.corners(p)].iter_mut().for_each(|i| *i = back[*i as usize]);
            self.is_mirrored[p] ^= self.is_mirrored[o];
        }
        for (p, original) in original.iter_mut().enumerate() {
            let onto = self.pieces.corners(*original as usize).start;
            let image = |slot: usize| onto + self.image[slot] as usize;
            let is_one =
                |same: &dyn Fn(usize, usize) -> bool| self.pieces.corners(p).all(|slot| same(slot, image(slot)));
            // No reader of a file could tell the two apart.
            if *original as usize != p && who.stacked.is_some_and(is_one) {
                *original = p as u32;
            }
        }
        (0..original.len()).filter(|p| original[*p] as usize == *p).for_each(|p| self.lie_still(p));
        Ok(())
    }
}
