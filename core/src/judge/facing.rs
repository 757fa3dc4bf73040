//! Which faces of a file neighbours outvote: converters turn some over, and a map that lays them flat beside the others is
//! sound.
//!
//! Two faces at an edge face one way when they run along it in opposite directions. Faces are joined over the edges that
//! the map does not cut, those that agree first, then over seams, as far as that contradicts nothing before. The lesser part
//! of each piece by area counts as turned; of equal ones that with fewer faces, then that without the first face. So no chart
//! that has two sides holds a contradiction. Edges of more than two faces and copies of one face (the same three places)
//! join nothing.

use super::edges::Edge;
use super::input::UvMesh;
use super::wedges::UvTopology;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::union_find::UnionFind;
use crate::mesh::view::NONE;

/// Scratch bytes for [`find_turned`].
pub const fn find_turned_need(faces: usize) -> usize {
    bytes_for::<u32>(faces.saturating_mul(2)) + bytes_for::<[f64; 2]>(faces) + bytes_for::<[u32; 2]>(faces)
}

/// Fills `turned` (one entry a face) with 1 where neighbours outvote a face, else 0. `solid` is the area of each face in
/// space. Near-linear.
pub fn find_turned(
    turned: &mut [u8], // (f)
    mesh: UvMesh,
    topology: &UvTopology,
    solid: &[f64], // (f)
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let faces = mesh.triangles.len();
    scratch.require(find_turned_need(faces))?;
    // Element f is face f as it is, element faces + f the same face turned; a set holds what faces one way.
    let mut sets = UnionFind::new(scratch.take::<u32>(2 * faces)?);
    let (area, count) = (scratch.take::<[f64; 2]>(faces)?, scratch.take::<[u32; 2]>(faces)?);
    let joins = || topology.edges.iter().filter(|e| e.face_count == 2 && are_neighbours(mesh, topology, e));
    let rises = |edge: &Edge, face: u32| topology.rises(mesh.triangles, face, edge);
    for (seam, agree) in [(false, true), (false, false), (true, true), (true, false)] {
        for edge in joins().filter(|e| e.is_seam() == seam && (rises(e, e.faces[0]) != rises(e, e.faces[1])) == agree) {
            let ([f, g], other) = (edge.faces, faces as u32);
            let (same, opposite) = if agree { (g, g + other) } else { (g + other, g) };
            if sets.find(f) != sets.find(opposite) {
                sets.union(f, same);
                sets.union(f + other, opposite);
            }
        }
    }
    // The lowest face of a piece is the root of the set that it is in as it is.
    let mut side_of = |f: usize| {
        let [kept, over] = [f, f + faces].map(|x| sets.find(x as u32) as usize);
        (kept.min(over), usize::from(over < kept))
    };
    for (f, solid) in solid.iter().enumerate() {
        let (piece, side) = side_of(f);
        area[piece][side] += solid;
        count[piece][side] += 1;
    }
    for (f, turned) in turned.iter_mut().enumerate() {
        let (piece, side) = side_of(f);
        let (area, count) = (area[piece], count[piece]);
        let lesser = usize::from((area[1], count[1]) <= (area[0], count[0]));
        *turned = u8::from(side == lesser);
    }
    Ok(())
}

/// Does the edge lie between two faces of which neither is a copy of the other?
fn are_neighbours(mesh: UvMesh, topology: &UvTopology, edge: &Edge) -> bool {
    let apex = |face: u32| {
        let mut places = mesh.triangles[face as usize].map(|v| topology.welded[v as usize]).into_iter();
        places.find(|v| *v != edge.low && *v != edge.high).unwrap_or(NONE)
    };
    let [f, g] = edge.faces;
    f != g && edge.low != edge.high && apex(f) != apex(g)
}

#[cfg(test)]
mod tests {
    use super::super::input::{areas, areas_need};
    use super::super::wedges::{uv_topology, uv_topology_need};
    use super::*;
    use glam::{DVec2, DVec3};
    use std::{vec, vec::Vec};

    /// A row of triangles over a strip: triangle i has the points i, i + 1, i + 2, all facing up; those listed are turned over.
    fn strip(count: u32, over: &[usize]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let positions = (0..count + 2).map(|i| DVec3::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
        let up = |i: u32| if i.is_multiple_of(2) { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] };
        let mut triangles: Vec<[u32; 3]> = (0..count).map(up).collect();
        over.iter().for_each(|f| triangles[*f].swap(1, 2));
        (positions, triangles)
    }

    fn found(positions: &[DVec3], triangles: &[[u32; 3]], shift: impl Fn(usize) -> f64) -> Vec<u8> {
        let flat = |(f, t): (usize, &[u32; 3])| t.map(|v| positions[v as usize].truncate() + DVec2::X * shift(f));
        let corner_uv: Vec<[DVec2; 3]> = triangles.iter().enumerate().map(flat).collect();
        let mesh = UvMesh { positions, triangles, corner_uv: &corner_uv };
        let faces = triangles.len();
        let need = find_turned_need(faces);
        let mut bytes = vec![0; areas_need(faces) + uv_topology_need(positions.len(), faces) + need];
        let mut scratch = Scratch::new(&mut bytes);
        let areas = areas(mesh, &mut scratch).unwrap();
        let topology = uv_topology(mesh, &mut scratch).unwrap();
        let mut turned = vec![7; faces];
        let mut few = vec![0; need - 1];
        assert!(find_turned(&mut turned, mesh, &topology, areas.solid, Scratch::new(&mut few)).is_err());
        find_turned(&mut turned, mesh, &topology, areas.solid, scratch).unwrap();
        turned
    }

    #[test]
    fn the_lesser_part_is_turned_within_charts_and_over_seams() {
        let over = [1, 4, 5];
        let expected: Vec<u8> = (0..9).map(|f| u8::from(over.contains(&f))).collect();
        let (positions, triangles) = strip(9, &over);
        assert_eq!(found(&positions, &triangles, |_| 0.0), expected);
        assert_eq!(found(&positions, &triangles, |f| (f / 4 * 20) as f64), expected, "three charts");
        let (positions, triangles) = strip(4, &[0, 1]);
        assert_eq!(found(&positions, &triangles, |_| 0.0), [0, 0, 1, 1], "of equal parts the first stays");
    }

    #[test]
    fn a_copy_of_a_face_is_no_neighbour() {
        let (positions, mut triangles) = strip(1, &[]);
        triangles.push(triangles[0]);
        assert_eq!(found(&positions, &triangles, |_| 0.0), [0, 0]);
        assert!(found(&[], &[], |_| 0.0).is_empty());
    }

    #[test]
    fn a_band_with_one_side_has_its_contradiction_at_the_seam() {
        // Five quads around a Moebius band, cut between the last and the first.
        let at = |i: u32, j: u32| if i < 5 { 2 * i + j } else { 1 - j };
        let quads = (0..5).flat_map(|i| [[at(i, 0), at(i + 1, 0), at(i + 1, 1)], [at(i, 0), at(i + 1, 1), at(i, 1)]]);
        let triangles: Vec<[u32; 3]> = quads.collect();
        let angle = |i: u32| core::f64::consts::TAU * f64::from(i) / 5.0;
        let positions: Vec<DVec3> =
            (0..10).map(|v| DVec3::new(libm::cos(angle(v / 2)), libm::sin(angle(v / 2)), f64::from(v % 2))).collect();
        // UVs of the last quad stand apart, so that both of its sides are seams.
        assert_eq!(found(&positions, &triangles, |f| if f / 2 == 4 { 50.0 } else { 0.0 }), [0; 10]);
    }
}
