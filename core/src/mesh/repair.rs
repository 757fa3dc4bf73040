//! From the user's polygons to a working mesh that every later stage can rely on.
//!
//! Weld, close cracks where that is asked for, triangulate, join faces at edges, orient, split what is not manifold; each step has its file. Only the
//! working copy changes: every working corner names the input corner that it stands for.
//! Guaranteed: every component is an oriented 2-manifold with boundary; an edge, named by its two vertices, has one
//! half-edge or two twins of opposite direction (so `topology::twins` finds the same twins); the corners at a vertex are
//! one fan; no face has a vertex twice; the triangles of a polygon hang together, so that its corners keep one UV each.
//! Scaling the input by a power of two changes no bit of the result but `extent` and `centre`.
//! Limits: faces of zero area stay, since taking them out would open cracks, but for those that are [`idle`](super::idle);
//! vertices that are near one another but not equal stay apart unless [`Weld`] says otherwise. Faces that are turned round against the input have a mirrored UV in the eyes of a reader that goes
//! by the file's order of corners, see [`Facing`].

use super::cracks::{Closed, Weld, close_cracks, close_cracks_need};
use super::draft::Draft;
use super::facets::{FacetCounts, facets, facets_need};
use super::idle::{idle, idle_need, is_flat};
use super::loops::{border_count, count_loops};
use super::manifold::{Crowds, Pull, Untangled, join_crowds, join_pairs, sort_edges, split_vertices, untangle};
use super::orient::{cut_conflicts, orient, orient_need};
use super::polygons::{Counts, Polygons};
use super::unit_box::UnitBox;
use super::view::{NONE, next};
use super::weld::{weld, weld_need};
use super::working::{CLOSED, DIAGONAL, FORCED, Working};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::union_find::UnionFind;
use glam::{DVec2, DVec3};

/// What happens where neighbouring faces of the input disagree about the outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Facing {
    /// The lesser part of each piece of surface is turned round, so that the piece stays whole.
    #[default]
    Turned,
    /// Every face keeps the input's orientation, and the edges between faces that disagree are cut: a reader that goes
    /// by the file's order of corners sees no mirrored UV.
    AsGiven,
}

/// What was repaired.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RepairSummary {
    /// Input vertices merged into another at the same place.
    pub welded_vertices: usize,
    /// Triangles that would have had a vertex twice.
    pub dropped_triangles: usize,
    /// Polygons of which no triangle is left.
    pub dropped_polygons: usize,
    /// Polygons that name their vertices again and again, of which one ring is left.
    pub damaged_polygons: usize,
    /// Working faces of (nearly) zero area, see [`idle`](super::idle).
    pub flat_faces: usize,
    /// Working faces turned round against the input.
    pub flipped_faces: usize,
    /// Edges of two faces or more of which one at least has no neighbour.
    pub split_edges: usize,
    /// Those of them where a face without a neighbour is the copy of another.
    pub copied_edges: usize,
    /// Those of them whose two faces cannot both face outwards: each surface with one side only has some.
    pub one_sided_edges: usize,
    /// Working vertices beyond one for each place.
    pub split_vertices: usize,
    /// Pieces of surface.
    pub components: usize,
    /// Closed curves that the border consists of.
    pub boundary_loops: usize,
    /// V - E + F over all components.
    pub euler: i64,
    /// Handles of all components together.
    pub genus: i64,
    /// Under [`Weld::Within`] and [`Weld::Auto`]: sides of polygons on whose other side no polygon was.
    pub border_edges: usize,
    /// Edges where two of them were joined.
    pub closed_edges: usize,
    /// How far apart these were at the most, over the diagonal of the mesh's box.
    pub weld_tolerance: f64,
    /// How far the vertices that were welded over cracks were apart on the mean, over the largest side of that box.
    pub crack_width: f64,
}

/// Why there is no working mesh. Nothing was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RepairError {
    /// More memory is needed (usize::MAX: more corners than 32 bits can number).
    Scratch(ScratchTooSmall),
    /// A coordinate of this vertex, which a corner names, is NaN or infinite.
    NotFinite {
        /// Input vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there, or a polygon this corner that is not there.
    BadIndex {
        /// Input corner.
        corner: usize,
    },
    /// No polygon has three different corners.
    NoTriangle,
}

impl From<ScratchTooSmall> for RepairError {
    fn from(e: ScratchTooSmall) -> Self {
        RepairError::Scratch(e)
    }
}

impl core::fmt::Display for RepairError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RepairError::Scratch(e) => e.fmt(f),
            RepairError::NotFinite { vertex } => write!(f, "vertex {vertex} has a coordinate that is not a number"),
            RepairError::BadIndex { corner } => write!(f, "corner {corner} names a vertex that does not exist"),
            RepairError::NoTriangle => write!(f, "the mesh holds no triangle with three different corners"),
        }
    }
}

impl core::error::Error for RepairError {}

/// Bytes that must be free for [`repair`]: about 135 a triangle (150 where nothing is welded), and 85 a corner of the
/// longest polygon. When it is done, 65 (at the most 145) of them a triangle stay taken.
pub fn repair_need(counts: &Counts) -> usize {
    repair_welding_need(counts, Weld::Equal)
}

/// Bytes that must be free for [`repair_welding`].
pub fn repair_welding_need(counts: &Counts, weld: Weld) -> usize {
    let Counts { vertices, triangles, .. } = *counts;
    if counts.are_too_many() {
        return usize::MAX;
    }
    let kept =
        bytes_for::<u32>(vertices).saturating_add(bytes_for::<u32>(triangles)).saturating_add(Draft::need(triangles));
    let working = bytes_for::<DVec3>(3 * triangles).saturating_add(bytes_for::<u32>(3 * triangles));
    kept.saturating_add(working.max(temporary_need(counts, weld)))
}

/// What [`repair`] needs besides what it hands back.
fn temporary_need(counts: &Counts, weld: Weld) -> usize {
    let Counts { vertices, triangles, longest, polygons, .. } = *counts;
    let edges = bytes_for::<[u32; 3]>(3 * triangles)
        .saturating_add(bytes_for::<u8>(3 * triangles))
        .saturating_add(orient_need(triangles).max(bytes_for::<u8>(vertices)));
    let facets = bytes_for::<u8>(polygons).saturating_add(facets_need(vertices, longest));
    let steps = weld_need(vertices).max(idle_need(counts)).max(facets).max(edges);
    let exact = bytes_for::<u32>(if weld == Weld::Equal { 0 } else { vertices });
    let steps = if weld == Weld::Equal { steps } else { steps.max(close_cracks_need(counts)) };
    bytes_for::<u64>(polygons.saturating_add(1)).saturating_add(exact).saturating_add(steps)
}

/// Makes the working mesh. Its slices come from `out`, where the memory for the work itself is free again afterwards.
///
/// O(n log n) in vertices and corners, plus what [`polygon`](super::polygon) says for long concave polygons.
pub fn repair<'a>(
    input: &Polygons,
    facing: Facing,
    out: &mut Scratch<'a>,
) -> Result<(Working<'a>, RepairSummary), RepairError> {
    repair_welding(input, facing, Weld::Equal, out)
}

/// [`repair`], with cracks closed.
pub fn repair_welding<'a>(
    input: &Polygons,
    facing: Facing,
    cracks: Weld,
    out: &mut Scratch<'a>,
) -> Result<(Working<'a>, RepairSummary), RepairError> {
    out.require(repair_welding_need(&input.counts(), cracks))?;
    check(input)?;
    let (triangles, longest) = input.size();
    let mut summary = RepairSummary::default();

    let welded = out.take_filled::<u32>(input.positions.len(), NONE)?;
    let component = out.take::<u32>(triangles)?;
    let mut draft = Draft::take(out, triangles)?;
    let vertex_count;
    let unit;
    {
        let mut frame = out.frame();
        for &v in input.polygons().flat_map(|p| &input.corners[p.start as usize..p.end as usize]) {
            welded[v as usize] = v;
        }
        summary.welded_vertices = weld(welded, input.positions, frame.frame())?;
        let whole = UnitBox::new(welded.iter().filter(|v| **v != NONE).map(|v| input.positions[*v as usize]));
        let equal = frame.take::<u32>(if cracks == Weld::Equal { 0 } else { welded.len() })?;
        if cracks != Weld::Equal {
            equal.copy_from(welded);
            let Closed { border_edges, tolerance, width } = close_cracks(welded, input, &whole, cracks, frame.frame())?;
            (summary.border_edges, summary.weld_tolerance) = (border_edges, tolerance);
            summary.crack_width = width;
        }

        let signature = frame.take::<u64>(input.polygon_start.len())?;
        let found = {
            let mut frame = frame.frame();
            let idle = idle(input, welded, &whole, &mut frame)?;
            facets(&mut draft, signature, input, welded, idle, &whole, longest, frame)?
        };
        let FacetCounts { triangles: count, dropped, damaged } = found;
        if count == 0 {
            return Err(RepairError::NoTriangle);
        }
        summary.dropped_triangles = triangles - count;
        (summary.dropped_polygons, summary.damaged_polygons) = (dropped, damaged);
        draft = draft.shorten(count);
        unit = UnitBox::new(draft.faces.as_flattened().iter().map(|v| input.positions[*v as usize]));
        vertex_count = join_and_split(&mut draft, &mut summary, input, facing, signature, &unit, &mut frame)?;
        mark_kept_borders(&mut draft, input);
        summary.closed_edges = mark_closed(&mut draft, input, equal);
    }
    let (component, component_count) = components(component, &draft);

    let positions = out.take::<DVec3>(vertex_count)?;
    let vertex_source = out.take::<u32>(vertex_count)?;
    for (&v, &c) in draft.faces.as_flattened().iter().zip(&*draft.corner_source) {
        let source = welded[input.corners[c as usize] as usize];
        vertex_source[v as usize] = source;
        positions[v as usize] = unit.place(input.positions[source as usize]);
    }
    let Draft { faces, corner_source, polygon, twin, fixed } = draft;
    let working = Working {
        faces,
        positions,
        corner_source,
        vertex_source,
        twin,
        fixed,
        polygon,
        component,
        component_count,
        welded,
        centre: unit.centre,
        extent: unit.half * 2.0,
    };
    measure(&mut summary, &working);
    Ok((working, summary))
}

/// Every corner names a vertex, and every vertex that is named is finite.
pub(super) fn check(input: &Polygons) -> Result<(), RepairError> {
    for ends in input.polygon_start.windows(2) {
        if ends[0] > ends[1] || ends[1] as usize > input.corners.len() {
            return Err(RepairError::BadIndex { corner: ends[1] as usize });
        }
        for corner in ends[0] as usize..ends[1] as usize {
            let vertex = input.corners[corner] as usize;
            let position = input.positions.get(vertex).ok_or(RepairError::BadIndex { corner })?;
            if !position.is_finite() {
                return Err(RepairError::NotFinite { vertex });
            }
        }
    }
    Ok(())
}

/// Twins, orientation and vertices of the draft. Returns the number of vertices.
fn join_and_split(
    draft: &mut Draft,
    summary: &mut RepairSummary,
    input: &Polygons,
    facing: Facing,
    signature: &[u64],
    unit: &UnitBox,
    frame: &mut Scratch,
) -> Result<usize, ScratchTooSmall> {
    let faces = draft.faces.len();
    let all_edges = frame.take::<[u32; 3]>(3 * faces)?;
    let done = frame.take::<u8>(3 * faces)?;

    let diagonal = |h: usize| draft.fixed[h] == DIAGONAL;
    let sides = sort_edges(all_edges, draft, diagonal);
    let edges = &mut all_edges[..sides];
    join_pairs(draft, edges, signature);
    if facing == Facing::Turned {
        summary.flipped_faces = orient(draft, edges, input, unit, frame.frame())?;
    }
    summary.one_sided_edges = cut_conflicts(draft);
    let place = |v: u32| unit.place(input.positions[v as usize]);
    let Crowds { crowds, split, copied } = join_crowds(draft, edges, signature, place);
    (summary.split_edges, summary.copied_edges) = (split, copied);

    let places = count_places(draft, frame.frame().take::<u8>(input.positions.len())?);
    let mut vertices = split_vertices(draft, done);
    // Without diagonals and crowds each edge has two welded vertices of its own already.
    let may_tangle = summary.split_edges > 0 || crowds > 0 || sides < 3 * faces;
    for pull in [Pull::Low, Pull::High, Pull::Whole].into_iter().filter(|_| may_tangle) {
        let count = sort_edges(all_edges, draft, |_| false);
        let Untangled { tangles, cut } = untangle(draft, &all_edges[..count], done, pull);
        if tangles == 0 {
            break;
        }
        summary.split_edges += cut;
        vertices = split_vertices(draft, done);
    }
    summary.split_vertices = vertices - places;
    done.fill(0);
    summary.boundary_loops = count_loops(draft.twin, done);
    Ok(vertices)
}

/// How many different vertices the faces have; `seen` is zero, one entry an input vertex.
fn count_places(draft: &Draft, seen: &mut [u8]) -> usize {
    draft.faces.as_flattened().iter().for_each(|v| seen[*v as usize] = 1);
    seen.iter().map(|s| usize::from(*s)).sum()
}

/// Numbers the components by their lowest faces; what hangs together over twins is one. Returns how many there are.
fn components<'a>(component: &'a mut [u32], draft: &Draft) -> (&'a [u32], usize) {
    let component = &mut component[..draft.faces.len()];
    let mut sets = UnionFind::new(component);
    for (h, &twin) in draft.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
        sets.union(h as u32 / 3, twin / 3);
    }
    let mut count = 0;
    for f in 0..component.len() {
        // The entry is f itself at the lowest face of a set, else a lower face of the set, which has its number.
        component[f] = match component[f] as usize {
            lower if lower < f => component[lower],
            _ => {
                count += 1;
                count as u32 - 1
            }
        };
    }
    (component, count)
}

/// Marks the edges where both faces came with UVs that differ at an end.
fn mark_kept_borders(draft: &mut Draft, input: &Polygons) {
    let Some(uv) = input.kept_uv else { return };
    let at = |c: u32| uv.get(draft.corner_source[c as usize] as usize).copied().unwrap_or(DVec2::NAN);
    for h in 0..draft.twin.len() as u32 {
        let twin = draft.twin[h as usize];
        if twin != NONE && draft.fixed[h as usize] != DIAGONAL {
            let (ours, theirs) = ([at(h), at(next(h))], [at(next(twin)), at(twin)]);
            let mapped = ours.iter().chain(&theirs).all(|uv| !uv.is_nan());
            draft.fixed[h as usize] = if mapped && ours != theirs { FORCED } else { 0 };
        }
    }
}

/// Marks the edges whose faces would have no neighbour there if only vertices at `equal` places were one; returns how many.
fn mark_closed(draft: &mut Draft, input: &Polygons, equal: &[u32]) -> usize {
    let at = |draft: &Draft, c: u32| {
        let vertex = input.corners[draft.corner_source[c as usize] as usize];
        equal.get(vertex as usize).copied().unwrap_or(NONE)
    };
    let mut count = 0;
    for h in 0..draft.twin.len() as u32 {
        let twin = draft.twin[h as usize];
        if twin != NONE && draft.fixed[h as usize] != DIAGONAL {
            let ends = [at(draft, h), at(draft, next(h))];
            if ends != [at(draft, next(twin)), at(draft, twin)] {
                count += usize::from(h < twin);
                if draft.fixed[h as usize] == 0 {
                    draft.fixed[h as usize] = CLOSED;
                }
            }
        }
    }
    count
}

/// Counts what the finished mesh shows.
fn measure(summary: &mut RepairSummary, working: &Working) {
    let mesh = working.mesh();
    let flat = mesh.faces.iter().filter(|face| is_flat(face.map(|v| mesh.positions[v as usize])));
    summary.flat_faces = flat.count();
    let edges = (working.twin.len() + border_count(working.twin)) / 2;
    summary.components = working.component_count;
    summary.euler = mesh.positions.len() as i64 - edges as i64 + mesh.faces.len() as i64;
    summary.genus = (2 * summary.components as i64 - summary.boundary_loops as i64 - summary.euler) / 2;
}
