//! One orientation for each piece of surface that hangs together over edges of two faces.
//!
//! Breadth first from the lowest face of each piece, polygon by polygon, over faces that agree as far as that goes and
//! over one edge of disagreement only then; the orientation that has more area stays, so the lesser part is turned
//! round. On a surface with one side only (Moebius, Klein) some edges disagree in the end, and [`cut_conflicts`] opens
//! them: the seam of the input's own orientation where it has just one.

use super::draft::Draft;
use super::polygons::Polygons;
use super::unit_box::UnitBox;
use super::view::NONE;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};

/// Scratch bytes for [`orient`] with `faces` triangles.
pub(super) const fn orient_need(faces: usize) -> usize {
    bytes_for::<u32>(faces).saturating_add(bytes_for::<u8>(faces))
}

const KEPT: u8 = 1;
const TURNED: u8 = 2;

/// Where half-edge `h` stands after its face is turned round: its corners 1 and 2 change places.
const fn turned(h: u32) -> u32 {
    h - h % 3 + 2 - h % 3
}

/// Turns faces so that as many as possible of the paired edges run in opposite directions in their two faces, in the
/// draft and in the half-edges of `edges` (low vertex, high vertex, half-edge). Returns how many faces were turned.
pub(super) fn orient(
    draft: &mut Draft,
    edges: &mut [[u32; 3]],
    input: &Polygons,
    unit: &UnitBox,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let queue = scratch.take::<u32>(draft.faces.len())?;
    let side = scratch.take::<u8>(draft.faces.len())?; // 0 (not seen), KEPT or TURNED
    for seed in 0..draft.faces.len() {
        if side[seed] == 0 {
            let piece = spread(queue, side, draft, seed);
            settle(side, piece, draft, input, unit);
        }
    }
    let halves = |f: usize| 3 * f..3 * f + 3;
    for f in (0..side.len()).filter(|f| side[*f] == TURNED) {
        draft.faces[f].swap(1, 2);
        draft.corner_source[halves(f)].swap(1, 2);
        draft.twin[halves(f)].swap(0, 2);
        draft.fixed[halves(f)].swap(0, 2);
    }
    let renamed = |h: u32| if h != NONE && side[(h / 3) as usize] == TURNED { turned(h) } else { h };
    draft.twin.iter_mut().for_each(|t| *t = renamed(*t));
    edges.iter_mut().for_each(|e| e[2] = renamed(e[2]));
    Ok(side.iter().filter(|s| **s == TURNED).count())
}

/// Gives every face that can be reached from `seed` a side, and returns these faces in the order of the search: all
/// that can be reached through faces that agree, then over one edge whose faces disagree, and again.
fn spread<'q>(queue: &'q mut [u32], side: &mut [u8], draft: &Draft, seed: usize) -> &'q [u32] {
    let mut end = reach(queue, 0, side, draft, seed, KEPT);
    let (mut agreeing, mut disagreeing) = (0, 0); // faces of the queue whose edges of each kind have been crossed
    while disagreeing < end {
        let same = agreeing < end;
        let at = if same { &mut agreeing } else { &mut disagreeing };
        let f = queue[*at] as usize;
        *at += 1;
        for h in 3 * f as u32..3 * f as u32 + 3 {
            let twin = draft.twin[h as usize];
            if twin != NONE && side[(twin / 3) as usize] == 0 && (draft.vertex(h) != draft.vertex(twin)) == same {
                let which = if same { side[f] } else { KEPT + TURNED - side[f] };
                end = reach(queue, end, side, draft, (twin / 3) as usize, which);
            }
        }
    }
    &queue[..end]
}

/// Puts the polygon of `face` at the end of the queue, on side `which`. Returns the queue's new end.
fn reach(queue: &mut [u32], mut end: usize, side: &mut [u8], draft: &Draft, face: usize, which: u8) -> usize {
    for f in draft.polygon_faces(face) {
        queue[end] = f as u32;
        side[f] = which;
        end += 1;
    }
    end
}

/// Swaps the sides of a piece if more area, or as much area and more faces, would be turned than kept.
fn settle(side: &mut [u8], piece: &[u32], draft: &Draft, input: &Polygons, unit: &UnitBox) {
    let (mut area, mut count) = ([0.0; 2], [0; 2]);
    for &f in piece {
        let [a, b, c] = draft.faces[f as usize].map(|v| unit.place(input.positions[v as usize]));
        let which = usize::from(side[f as usize] == TURNED);
        area[which] += sqrt((b - a).cross(c - a).length_squared());
        count[which] += 1;
    }
    if (area[1], count[1]) > (area[0], count[0]) {
        piece.iter().for_each(|&f| side[f as usize] = KEPT + TURNED - side[f as usize]);
    }
}

/// Takes the twins of half-edges apart that run in the same direction; returns how many edges that cuts. Diagonals never do.
pub(super) fn cut_conflicts(draft: &mut Draft) -> usize {
    let mut count = 0;
    for h in 0..draft.twin.len() as u32 {
        let twin = draft.twin[h as usize];
        if twin != NONE && draft.vertex(h) == draft.vertex(twin) {
            draft.twin[h as usize] = NONE;
            draft.twin[twin as usize] = NONE;
            count += 1;
        }
    }
    count
}
