//! Which faces stay joined at an edge, and which corners stay one vertex, so that every piece is a 2-manifold.
//!
//! An edge of two faces joins them. Where more meet, faces of opposite direction are joined two by two: if directions
//! alternate around the edge, each two that enclose solid space (touching boxes stay boxes); otherwise the two that
//! lie flattest first (a fin leaves its wall whole, crossing sheets stay sheets). What finds no partner becomes border.
//! Polygons on the same set of vertices are copies of one another and are never joined.
//! A vertex becomes one vertex for each fan of corners around it (Gueziec, Taubin, Lazarus, Horn 2001).
//! Guaranteed at the end: each edge, named by its two working vertices, has one half-edge, or two that are twins and run
//! in opposite directions; the corners at a vertex are one fan.

use super::draft::Draft;
use super::idle::is_flat;
use super::topology::fan_start;
use super::view::{NONE, next, prev};
use super::working::DIAGONAL;
use crate::base::real::atan2;
use crate::base::room::Room;
use crate::base::slices::Slices;
use crate::base::sort;
use core::f64::consts::{PI, TAU};
use glam::DVec3;
use heapless::Vec;

/// Faces at one edge that are still told apart; beyond, all become border. Pairing is cubic in it: 8 copies of a
/// sheet take 1 us a half-edge, 32 copies (64 faces at an edge) 4 us, and with 256 faces it would be 60 us.
const MOST_AT_AN_EDGE: usize = 64;

/// Radians between neighbouring faces around an edge below which "the space between them" means nothing.
const LEAST_SECTOR: f64 = 1e-6;

/// Fills `edges` (up to 3 a face) with (low vertex, high vertex, half-edge) of the half-edges that are not `skipped`,
/// sorted. Returns how many.
pub(super) fn sort_edges(edges: &mut [[u32; 3]], draft: &Draft, skipped: impl Fn(usize) -> bool) -> usize {
    let mut count = 0;
    for h in (0..draft.twin.len()).filter(|h| !skipped(*h)) {
        let (a, b) = (draft.vertex(h as u32), draft.vertex(next(h as u32)));
        edges[count] = [a.min(b), a.max(b), h as u32];
        count += 1;
    }
    sort::ascending(&mut edges[..count]);
    count
}

fn by_edge(edges: &[[u32; 3]]) -> impl Iterator<Item = &[[u32; 3]]> {
    edges.runs(|a, b| a[..2] == b[..2])
}

fn join(twin: &mut [u32], a: u32, b: u32) {
    twin[a as usize] = b;
    twin[b as usize] = a;
}

/// May the faces of these half-edges be neighbours: is neither a copy of the other?
fn may_join(draft: &Draft, signature: &[u64], a: u32, b: u32) -> bool {
    let [p, q] = [a, b].map(|h| draft.polygon[(h / 3) as usize]);
    p == q || signature[p as usize] != signature[q as usize]
}

/// Joins the two faces of every edge that has two, whatever their directions.
pub(super) fn join_pairs(draft: &mut Draft, edges: &[[u32; 3]], signature: &[u64]) {
    for group in by_edge(edges) {
        if let &[[.., a], [.., b]] = group
            && may_join(draft, signature, a, b)
        {
            join(draft.twin, a, b);
        }
    }
}

/// A face at a crowded edge.
#[derive(Clone, Copy)]
struct Page {
    /// Around the edge, counter-clockwise looking from its high end to its low end.
    angle: f64,
    /// Runs from the low to the high vertex: the solid side lies clockwise of it.
    rises: bool,
    half: u32,
    /// Without area: it has no side of the edge, and takes no neighbour from faces that have.
    thin: bool,
    /// Has a copy that faces the other way at the same edge: a flap of no thickness, which hides a sheet that goes on.
    flap: bool,
}

/// What [`join_crowds`] found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Crowds {
    /// Edges of more than two faces.
    pub crowds: usize,
    /// Edges of two faces or more of which one at least has no partner.
    pub split: usize,
    /// Those of them where one without a partner has a copy.
    pub copied: usize,
}

/// Joins faces at the edges that have more than two.
pub(super) fn join_crowds(
    draft: &mut Draft,
    edges: &[[u32; 3]],
    signature: &[u64],
    place: impl Fn(u32) -> DVec3,
) -> Crowds {
    let mut found = Crowds::default();
    for group in by_edge(edges).filter(|g| g.len() > 1) {
        found.crowds += usize::from(group.len() > 2);
        if group.len() > 2 && group.len() <= MOST_AT_AN_EDGE {
            let mut pages = pages(draft, group, signature, &place);
            let mut thin = pages.clone();
            thin.retain(|p| p.thin);
            pages.retain(|p| !p.thin);
            if join_solids(draft, &pages) {
                pages.clear();
            } else {
                join_flattest(draft, &mut pages, signature);
            }
            if !thin.is_empty() {
                thin.iter().for_each(|p| pages.put(*p));
                join_flattest(draft, &mut pages, signature);
            }
        }
        found.split += usize::from(group.iter().any(|e| draft.twin[e[2] as usize] == NONE));
        let is_alone = |h: u32| draft.twin[h as usize] == NONE;
        let has_copy = |a: u32| group.iter().any(|&[.., b]| !may_join(draft, signature, a, b));
        found.copied += usize::from(group.iter().any(|&[.., h]| is_alone(h) && has_copy(h)));
    }
    found
}

/// The faces of one edge in order around it.
fn pages(
    draft: &Draft,
    group: &[[u32; 3]],
    signature: &[u64],
    place: &impl Fn(u32) -> DVec3,
) -> Vec<Page, MOST_AT_AN_EDGE> {
    let [low, high, first] = group[0];
    let (origin, axis) = (place(low), place(high) - place(low));
    let away = |h: u32| {
        let r = place(draft.vertex(prev(h))) - origin;
        r - axis * (r.dot(axis) / axis.length_squared())
    };
    let is_thin = |h: u32| is_flat(draft.faces[(h / 3) as usize].map(place));
    let x = away(group.iter().map(|e| e[2]).find(|h| !is_thin(*h)).unwrap_or(first));
    let y = axis.normalize_or_zero().cross(x);
    let mut pages = Vec::new();
    for &[.., half] in group {
        let r = away(half);
        let rises = draft.vertex(half) == low;
        let opposite = |e: &&[u32; 3]| (draft.vertex(e[2]) == low) != rises;
        let flap = group.iter().filter(opposite).any(|e| !may_join(draft, signature, e[2], half));
        pages.put(Page { angle: atan2(r.dot(y), r.dot(x)), rises, half, thin: is_thin(half), flap });
    }
    sort::by(&mut pages, |a, b| a.angle.total_cmp(&b.angle).then(a.half.cmp(&b.half)));
    pages
}

/// Counter-clockwise from `a` to `b`, in [0, 2 pi).
fn sector(a: &Page, b: &Page) -> f64 {
    let s = b.angle - a.angle;
    if s < 0.0 { s + TAU } else { s }
}

/// If directions alternate, joins each two faces with solid space between them.
fn join_solids(draft: &mut Draft, pages: &[Page]) -> bool {
    let after = |i: usize| &pages[(i + 1) % pages.len()];
    let solid =
        (0..pages.len()).all(|i| pages[i].rises != after(i).rises && sector(&pages[i], after(i)) > LEAST_SECTOR);
    if solid {
        for i in (0..pages.len()).filter(|i| !pages[*i].rises) {
            join(draft.twin, pages[i].half, after(i).half);
        }
    }
    solid
}

/// Joins two faces of opposite directions, the flattest two first, until none are left; flaps last. Of equally flat ones
/// the convex, then the lower faces.
fn join_flattest(draft: &mut Draft, pages: &mut Vec<Page, MOST_AT_AN_EDGE>, signature: &[u64]) {
    loop {
        let mut best: Option<(bool, f64, f64, u32, u32)> = None;
        for falling in pages.iter().filter(|p| !p.rises) {
            for rising in pages.iter().filter(|p| p.rises) {
                let inside = sector(falling, rising);
                let flap = falling.flap || rising.flap;
                let rank = (flap, (inside - PI).abs(), inside, falling.half, rising.half);
                if best.is_none_or(|b| rank < b) && may_join(draft, signature, falling.half, rising.half) {
                    best = Some(rank);
                }
            }
        }
        let Some((.., a, b)) = best else { return };
        join(draft.twin, a, b);
        pages.retain(|p| p.half != a && p.half != b);
    }
}

/// Renames the vertices of the draft so that each fan of corners has its own, numbered by lowest corner. Returns
/// how many there are. `done` has one entry a corner.
pub(super) fn split_vertices(draft: &mut Draft, done: &mut [u8]) -> usize {
    done.fill(0);
    let mut count = 0;
    for c in 0..draft.twin.len() as u32 {
        if done[c as usize] != 0 {
            continue;
        }
        let start = fan_start(draft.twin, c);
        let mut at = start;
        loop {
            done[at as usize] = 1;
            draft.faces[(at / 3) as usize][(at % 3) as usize] = count;
            at = draft.twin[prev(at) as usize];
            if at == NONE || at == start {
                break;
            }
        }
        count += 1;
    }
    count as usize
}

/// How hard [`untangle`] pulls: the rounds of it in turn.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Pull {
    /// Polygons lose their neighbours on both sides of their corner at the lower vertex of the tangled edge.
    Low,
    /// The same at the higher vertex.
    High,
    /// Polygons lose all their neighbours.
    Whole,
}

/// What [`untangle`] did.
pub(super) struct Untangled {
    /// Tangled edges found.
    pub tangles: usize,
    /// Edges cut to undo them.
    pub cut: usize,
}

/// Undoes edges that have the same two working vertices and yet are different: two quads around a vertex that only
/// they have, both with the diagonal past it; a sheet that winds around an edge and comes back. No straight-line map is
/// injective on both. Two border edges are joined; else the polygons of all but the first edge get corners of their own.
///
/// If anything was tangled, vertices must be split again. Cutting only makes the sets of half-edges with the same ends
/// smaller, and a polygon by itself has a vertex for each of its corners, so nothing is tangled after `Pull::Whole`.
pub(super) fn untangle(draft: &mut Draft, edges: &[[u32; 3]], cut_here: &mut [u8], pull: Pull) -> Untangled {
    cut_here.fill(0);
    let mut result = Untangled { tangles: 0, cut: 0 };
    for group in by_edge(edges) {
        match *group {
            [_] => {}
            [[.., a], [.., b]] if draft.twin[a as usize] == b => {}
            [[.., a], [.., b]]
                if [a, b].iter().all(|h| draft.twin[*h as usize] == NONE) && draft.vertex(a) != draft.vertex(b) =>
            {
                join(draft.twin, a, b);
            }
            _ => {
                result.tangles += 1;
                mark_sides(cut_here, draft, group, pull);
            }
        }
    }
    for h in (0..draft.twin.len()).filter(|_| result.tangles > 0) {
        let twin = draft.twin[h];
        if twin != NONE && cut_here[h] + cut_here[twin as usize] > 0 {
            draft.twin[h] = NONE;
            draft.twin[twin as usize] = NONE;
            result.cut += 1;
        }
    }
    result
}

/// Marks the sides where the polygons of a tangled edge are to lose their neighbours.
fn mark_sides(cut_here: &mut [u8], draft: &Draft, group: &[[u32; 3]], pull: Pull) {
    let end = group[0][usize::from(pull == Pull::High)];
    let source = |c: u32| draft.corner_source[c as usize];
    let corner_at_end = |h: u32| source(if draft.vertex(h) == end { h } else { next(h) });
    let first = group[0][2];
    let stays = [first, draft.twin[first as usize]].map(|h| if h == NONE { NONE } else { corner_at_end(h) });
    for &[.., h] in group {
        let corner = corner_at_end(h);
        if pull != Pull::Whole && stays.contains(&corner) {
            continue;
        }
        let faces = draft.polygon_faces((h / 3) as usize);
        for side in 3 * faces.start as u32..3 * faces.end as u32 {
            let touches = pull == Pull::Whole || source(side) == corner || source(next(side)) == corner;
            if touches && draft.fixed[side as usize] != DIAGONAL {
                cut_here[side as usize] = 1;
            }
        }
    }
}
