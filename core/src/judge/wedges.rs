//! What is connected to what in UV: welded vertices, welded UV corners (wedges), edges, seams, charts.
//!
//! Vertices at bit-equal positions are one (so that an exporter that splits vertices at seams cannot hide them). Two
//! corners are one wedge when they stand at one vertex and their UVs agree to 1e-7 of the UV extent. An edge is a seam
//! when two faces along it have different wedges at an end; the open border is no seam. Charts are the components of
//! faces across equal wedge pairs, but for folds: where two faces are on one side of their edge in UV and what lies on both sides of
//! such edges coincides, as mirrored halves do in their plane, these are two charts, and the edge is no seam, for nothing shows
//! there. Where more than two faces meet at a place because pieces of surface lie upon one another,
//! the file's own vertices tell them apart: if each face shares its own with another, there are as many edges as pieces.
//! Everything is grouped by counting sorts: near-linear. Faces without UV belong to no edge and no chart.

use super::edges::{Edge, Ends, join, join_need};
use super::input::UvMesh;
use crate::base::buckets::{Buckets, buckets_need};
use crate::base::real::floor;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::mesh::view::NONE;
use crate::plane::grid::GRID_BITS;
use core::cmp::Ordering;
use glam::{DVec2, DVec3};

/// UVs at one vertex closer than about this share of the UV extent are one wedge. Six decimals in a file of a unit
/// atlas need more than 1e-6 apart to be seen as two; f32 rounding of one value stays below 6e-8.
pub const UV_TOLERANCE: f64 = 1e-7;

/// Connectivity of a UV map.
pub struct UvTopology<'a> {
    /// For each input vertex, the lowest vertex at the same place.
    pub welded: &'a [u32], // (n)
    /// Different places.
    pub vertex_count: usize,
    /// Wedge of each corner, 0..wedge_count; [`NONE`] without UV.
    pub wedge: &'a [[u32; 3]], // (f)
    /// Different wedges.
    pub wedge_count: usize,
    /// Chart of each face, numbered by their first faces; [`NONE`] without UV.
    pub chart: &'a [u32], // (f)
    /// Charts.
    pub chart_count: usize,
    /// Edges in order of (low, high).
    pub edges: &'a [Edge],
    /// Bit i is set where the side of corner i (to the next corner) is a seam.
    pub seam_sides: &'a [u8], // (f)
    /// Vertices - edges + faces of each chart, counted in UV; 1 is a disk.
    pub euler: &'a [i32], // (chart_count)
    /// Loops of each chart's border; those that touch in a wedge are one.
    pub loops: &'a [i32], // (chart_count)
}

impl UvTopology<'_> {
    /// Whether `face` runs along `edge` from its low end to its high one. Two faces of an edge that both do, or both do not,
    /// face opposite ways.
    pub fn rises(&self, triangles: &[[u32; 3]], face: u32, edge: &Edge) -> bool {
        let [a, b, c] = triangles[face as usize].map(|v| self.welded[v as usize]);
        [(a, b), (b, c), (c, a)].contains(&(edge.low, edge.high))
    }
}

/// Bytes that [`uv_topology`] takes, its own temporary ones included.
pub const fn uv_topology_need(vertices: usize, faces: usize) -> usize {
    let kept = bytes_for::<u32>(vertices)
        + bytes_for::<[u32; 3]>(faces)
        + 3 * bytes_for::<u32>(faces)
        + bytes_for::<u8>(faces)
        + bytes_for::<Edge>(3 * faces);
    let weld = bytes_for::<u32>(vertices);
    let join = join_need(vertices, faces);
    let count = bytes_for::<u8>(faces) + bytes_for::<u32>(3 * faces) + buckets_need(3 * faces, 3 * faces);
    let (mut most, mut i, steps) = (0, 0, [weld, join, count]);
    while i < steps.len() {
        most = if steps[i] > most { steps[i] } else { most };
        i += 1;
    }
    kept + most
}

/// Finds wedges, edges, seams and charts of `mesh`. All indices must be in range.
pub fn uv_topology<'s>(mesh: UvMesh, scratch: &mut Scratch<'s>) -> Result<UvTopology<'s>, ScratchTooSmall> {
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    scratch.require(uv_topology_need(vertices, faces))?;
    let welded = scratch.take::<u32>(vertices)?;
    let wedge = scratch.take_filled(faces, [NONE; 3])?;
    let chart = scratch.take_filled(faces, NONE)?;
    let euler = scratch.take::<i32>(faces)?;
    let loops = scratch.take::<i32>(faces)?;
    let seam_sides = scratch.take::<u8>(faces)?;
    let edges = scratch.take::<Edge>(3 * faces)?;

    let vertex_count = weld(welded, mesh.positions, scratch.frame())?;
    let wedge_count = weld_uv(wedge, mesh, welded, scratch.frame())?;
    let ends = Ends { triangles: mesh.triangles, corner_uv: mesh.corner_uv, welded, wedge };
    let bits = mesh.uv_box().map_or(GRID_BITS, |b| b.grid_bits());
    let (edge_count, chart_count) = join(edges, chart, seam_sides, ends, bits, scratch.frame())?;
    let (euler, loops) = (&mut euler[..chart_count], &mut loops[..chart_count]);
    {
        let mut frame = scratch.frame();
        let border_sides = frame.take::<u8>(faces)?;
        count_euler(euler, border_sides, chart, ends, wedge_count, frame.frame())?;
        count_loops(loops, border_sides, chart, ends, wedge_count, frame)?;
    }
    let edges = &edges[..edge_count];
    Ok(UvTopology { welded, vertex_count, wedge, wedge_count, chart, chart_count, edges, seam_sides, euler, loops })
}

/// Points each vertex to the lowest one at its place; returns the number of places. -0 and 0 are one place.
fn weld(welded: &mut [u32], positions: &[DVec3], mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
    let order = scratch.take::<u32>(positions.len())?;
    order.iter_mut().enumerate().for_each(|(i, v)| *v = i as u32);
    let place = |v: u32| positions[v as usize] + DVec3::ZERO;
    let compare = |a: u32, b: u32| {
        let (p, q) = (place(a), place(b));
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z))
    };
    sort::by(order, |a, b| compare(*a, *b).then(a.cmp(b)));
    let mut count = 0;
    for group in order.runs(|a, b| compare(*a, *b) == Ordering::Equal) {
        group.iter().for_each(|v| welded[*v as usize] = group[0]);
        count += 1;
    }
    Ok(count)
}

/// Numbers the wedges; returns how many there are.
fn weld_uv(
    wedge: &mut [[u32; 3]],
    mesh: UvMesh,
    welded: &[u32],
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let Some(uv_box) = mesh.uv_box() else { return Ok(0) };
    let step = UV_TOLERANCE * uv_box.extent();
    let vertex = |c: u32| welded[mesh.triangles[c as usize / 3][c as usize % 3] as usize];
    let cell = |c: u32| {
        let uv: DVec2 = mesh.corner_uv[c as usize / 3][c as usize % 3];
        (half_even(uv.x / step) as i64, half_even(uv.y / step) as i64)
    };
    let key = |c: u32| mesh.has_uv(c as usize / 3).then(|| vertex(c));
    let mut corners = Buckets::new(mesh.positions.len(), 3 * mesh.triangles.len(), key, &mut scratch)?;
    let mut count = 0;
    for v in 0..corners.key_count() {
        let here = corners.get_mut(v);
        sort::by_key(here, |c| (cell(*c), *c));
        for group in here.runs(|a, b| cell(*a) == cell(*b)) {
            group.iter().for_each(|c| wedge[*c as usize / 3][*c as usize % 3] = count as u32);
            count += 1;
        }
    }
    Ok(count)
}

/// Nearest integer, halves to the even one, as NumPy rounds: a UV on the middle between two cells welds as there.
fn half_even(x: f64) -> f64 {
    let low = floor(x);
    let rest = x - low;
    let odd = low - 2.0 * floor(low * 0.5) != 0.0;
    if rest > 0.5 || (rest == 0.5 && odd) { low + 1.0 } else { low }
}

/// Vertices - edges + faces of each chart, with wedges as its vertices; bit i of `border_sides` is set where the side of
/// corner i has no other side of its chart on it.
fn count_euler(
    euler: &mut [i32],
    border_sides: &mut [u8],
    chart: &[u32],
    ends: Ends,
    wedge_count: usize,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = chart.len();
    chart.iter().filter(|c| **c != NONE).for_each(|c| euler[*c as usize] += 1);
    {
        let key = |c: u32| Some(ends.wedge[c as usize / 3][c as usize % 3]).filter(|w| *w != NONE);
        let mut frame = scratch.frame();
        let mut corners = Buckets::new(wedge_count, 3 * faces, key, &mut frame)?;
        let chart_of = |c: &u32| chart[*c as usize / 3];
        for w in 0..wedge_count {
            let here = corners.get_mut(w);
            sort::by_key(here, chart_of);
            here.runs(|a, b| chart_of(a) == chart_of(b)).for_each(|g| euler[chart_of(&g[0]) as usize] += 1);
        }
    }
    let pair = |h: &u32| {
        let (p, q) = ends.wedges(*h);
        (p.min(q), p.max(q), chart[ends.face_side(*h).0])
    };
    let key = |h: u32| ends.has_uv(h).then(|| pair(&h).0);
    let mut half_edges = Buckets::new(wedge_count, 3 * faces, key, &mut scratch)?;
    for w in 0..wedge_count {
        let here = half_edges.get_mut(w);
        sort::by_key(here, pair);
        for group in here.runs(|a, b| pair(a) == pair(b)) {
            euler[pair(&group[0]).2 as usize] -= 1;
            if let [alone] = *group {
                let (face, side) = ends.face_side(alone);
                border_sides[face] |= 1 << side;
            }
        }
    }
    Ok(())
}

/// Loops of each chart's border: components of border sides by the wedges at their ends, and the charts of each.
fn count_loops(
    loops: &mut [i32],
    border_sides: &[u8],
    chart: &[u32],
    ends: Ends,
    wedge_count: usize,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let sides = 3 * chart.len();
    let on_border = |h: &u32| {
        let (face, side) = ends.face_side(*h);
        (border_sides[face] >> side) & 1 != 0
    };
    let component = scratch.take::<u32>(wedge_count)?;
    let mut sets = UnionFind::new(component);
    for h in (0..sides as u32).filter(on_border) {
        let (p, q) = ends.wedges(h);
        sets.union(p, q);
    }
    let count = sets.number();
    let key = |h: u32| on_border(&h).then(|| component[ends.wedges(h).0 as usize]);
    let mut border = Buckets::new(count, sides, key, &mut scratch)?;
    let chart_of = |h: &u32| chart[ends.face_side(*h).0];
    for c in 0..count {
        let here = border.get_mut(c);
        sort::by_key(here, chart_of);
        here.runs(|a, b| chart_of(a) == chart_of(b)).for_each(|g| loops[chart_of(&g[0]) as usize] += 1);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    /// A unit square of two faces; `shift` moves the second face's UVs.
    fn square(shift: f64) -> ([DVec3; 4], [[u32; 3]; 2], [[DVec2; 3]; 2]) {
        let uv = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let positions = uv.map(|p| p.extend(0.0));
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let mut corner_uv = triangles.map(|t: [u32; 3]| t.map(|v| uv[v as usize]));
        corner_uv[1].iter_mut().for_each(|p| *p += DVec2::splat(shift));
        (positions, triangles, corner_uv)
    }

    fn with_topology(mesh: UvMesh, check: impl Fn(UvTopology)) {
        let mut bytes = vec![0; uv_topology_need(mesh.positions.len(), mesh.triangles.len())];
        let short = bytes.len() - 1;
        assert!(uv_topology(mesh, &mut Scratch::new(&mut bytes[..short])).is_err());
        check(uv_topology(mesh, &mut Scratch::new(&mut bytes)).unwrap());
    }

    #[test]
    fn a_square_in_one_piece_is_one_disk_without_seams() {
        let (positions, triangles, corner_uv) = square(0.0);
        with_topology(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!((t.vertex_count, t.wedge_count, t.chart_count, t.edges.len()), (4, 4, 1, 5));
            assert_eq!((t.euler, t.loops, t.seam_sides), (&[1][..], &[1][..], &[0, 0][..]));
            let faces_of = |low, high| t.edges.iter().find(|e| (e.low, e.high) == (low, high)).unwrap().faces;
            assert_eq!((faces_of(0, 2), faces_of(0, 3)), ([1, 0], [1, NONE]));
        });
    }

    #[test]
    fn a_shift_cuts_the_diagonal() {
        let (positions, triangles, corner_uv) = square(1.0);
        with_topology(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!((t.wedge_count, t.chart_count, t.euler, t.loops), (6, 2, &[1, 1][..], &[1, 1][..]));
            assert_eq!(t.seam_sides, [0b100, 0b001]);
            let seam = t.edges.iter().find(|e| e.is_seam()).unwrap();
            assert_eq!((seam.low, seam.high, seam.face_count), (0, 2, 2));
        });
    }

    #[test]
    fn what_is_folded_onto_itself_is_two_charts_and_the_fold_no_seam() {
        let (positions, triangles, mut corner_uv) = square(0.0);
        corner_uv[1][2] = corner_uv[0][1];
        with_topology(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!((t.chart_count, t.euler, t.loops, t.seam_sides), (2, &[1, 1][..], &[1, 1][..], &[0, 0][..]));
        });
        // What coincides in part, or has no area, hangs together.
        corner_uv[1][2] = DVec2::new(0.9, 0.0);
        with_topology(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!(t.chart_count, 1);
        });
        corner_uv = [[DVec2::ZERO, DVec2::X, DVec2::ONE]; 2].map(|t| t.map(|uv| DVec2::splat(uv.x)));
        corner_uv[1][1] = corner_uv[0][2];
        corner_uv[1][2] = corner_uv[0][1];
        with_topology(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!(t.chart_count, 1);
        });
    }

    #[test]
    fn vertices_split_by_an_exporter_are_one() {
        let (positions, _, corner_uv) = square(0.0);
        let mut split = positions.to_vec();
        split.extend([positions[0], positions[2], -positions[0]]); // the last is (-0, -0, -0)
        let triangles = [[0, 1, 5], [4, 2, 3]];
        with_topology(UvMesh { positions: &split, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!((t.vertex_count, t.chart_count), (4, 1));
            assert_eq!(t.welded, [0, 1, 2, 3, 0, 2, 0]);
        });
    }

    #[test]
    fn faces_without_uv_belong_to_nothing() {
        let (positions, triangles, mut corner_uv) = square(0.0);
        corner_uv[0][1].x = f64::NAN;
        with_topology(UvMesh { positions: &positions, triangles: &triangles, corner_uv: &corner_uv }, |t| {
            assert_eq!((t.chart, t.edges.len(), t.wedge[0]), (&[NONE, 0][..], 3, [NONE; 3]));
        });
        with_topology(UvMesh { positions: &[], triangles: &[], corner_uv: &[] }, |t| {
            assert_eq!((t.chart_count, t.edges.len()), (0, 0));
        });
    }

    #[test]
    fn halves_round_to_the_even_integer() {
        assert_eq!([0.5, 1.5, -0.5, -1.5, 2.4, -2.6].map(half_even), [0.0, 2.0, 0.0, -2.0, 2.0, -3.0]);
    }
}
