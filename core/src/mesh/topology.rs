//! Adjacency of an oriented triangle mesh: each half-edge's twin, and the fan of corners around a vertex.
//!
//! Built by sorting half-edges by their end vertices: O(f log f), no hashing. Where more than two faces meet at an
//! edge, or two faces run along it in the same direction, none of its half-edges gets a twin: `repair` splits such
//! edges before anything else sees the mesh.

use super::view::{MeshView, NONE, next, prev};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;

/// Scratch bytes for [`twins`] on a mesh of `faces` triangles.
pub const fn twins_need(faces: usize) -> usize {
    bytes_for::<[u32; 3]>(3 * faces)
}

/// Fills `twin` (one entry a corner): the corner whose half-edge runs the other way along the same edge, or [`NONE`]
/// on the border. Returns how many edges had more than two half-edges or two of the same direction.
pub fn twins(twin: &mut [u32], mesh: MeshView, mut scratch: Scratch) -> Result<usize, ScratchTooSmall> {
    scratch.require(twins_need(mesh.faces.len()))?;
    let keys = scratch.take::<[u32; 3]>(mesh.corner_count())?; // (low vertex, high vertex, corner)
    for (c, key) in keys.iter_mut().enumerate() {
        let (a, b) = (mesh.vertex(c as u32), mesh.vertex(next(c as u32)));
        *key = [a.min(b), a.max(b), c as u32];
    }
    sort::ascending(keys);
    twin.fill(NONE);
    let mut bad = 0;
    for group in keys.runs(|a, b| a[..2] == b[..2]) {
        match group {
            [_] => {}
            [p, q] if mesh.vertex(p[2]) != mesh.vertex(q[2]) => {
                twin[p[2] as usize] = q[2];
                twin[q[2] as usize] = p[2];
            }
            _ => bad += 1,
        }
    }
    Ok(bad)
}

/// Fills `corner` (one entry a vertex) with the lowest corner at each vertex; [`NONE`] where no face has it.
pub fn vertex_corners(corner: &mut [u32], faces: &[[u32; 3]]) {
    corner.fill(NONE);
    for (c, &v) in faces.as_flattened().iter().enumerate().rev() {
        corner[v as usize] = c as u32;
    }
}

/// The first corner of the fan that `corner` is in: at a border vertex the one whose half-edge is on the border, so
/// that the fan runs counter-clockwise from there; at an inner vertex `corner` itself.
///
/// `twin` is symmetric (as from [`twins`] or `repair`), which makes the walk end.
pub fn fan_start(twin: &[u32], corner: u32) -> u32 {
    let mut at = corner;
    while twin[at as usize] != NONE {
        at = next(twin[at as usize]);
        if at == corner {
            break;
        }
    }
    at
}

/// The corners around the vertex of `corner`, counter-clockwise, each once, from [`fan_start`] on. The half-edges of
/// these corners leave the vertex; at a border vertex one more edge arrives, that of `prev` of the last corner.
pub fn fan(twin: &[u32], corner: u32) -> impl Iterator<Item = u32> {
    let start = fan_start(twin, corner);
    core::iter::successors(Some(start), move |&c| {
        let left = twin[prev(c) as usize];
        (left != NONE && left != start).then_some(left)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::vec;

    #[test]
    fn two_triangles_share_one_edge() {
        let positions = [DVec3::ZERO; 4];
        let faces = [[0, 1, 2], [2, 1, 3]];
        let mesh = MeshView { positions: &positions, faces: &faces };
        let mut twin = [0; 6];
        let mut bytes = vec![0u8; twins_need(2)];
        assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(0));
        assert_eq!(twin, [NONE, 3, NONE, 1, NONE, NONE]);
    }

    #[test]
    fn an_edge_of_three_faces_gets_no_twins() {
        let positions = [DVec3::ZERO; 5];
        let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let mesh = MeshView { positions: &positions, faces: &faces };
        let mut twin = [0; 9];
        let mut bytes = vec![0u8; twins_need(3)];
        assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(1));
        assert!(twin.iter().all(|t| *t == NONE));
    }

    #[test]
    fn a_fan_runs_counter_clockwise_from_the_border_or_all_round() {
        // Four triangles around vertex 0, then the same without the last.
        let faces = [[0, 1, 2], [2, 3, 0], [3, 4, 0], [0, 4, 1]];
        for count in [4, 3] {
            let mesh = MeshView { positions: &[DVec3::ZERO; 5], faces: &faces[..count] };
            let mut twin = vec![0; 3 * count];
            let mut bytes = vec![0u8; twins_need(count)];
            assert_eq!(twins(&mut twin, mesh, Scratch::new(&mut bytes)), Ok(0));
            let mut corners = [0; 5];
            vertex_corners(&mut corners, mesh.faces);
            assert_eq!(corners, [0, 1, 2, 4, 7]);
            let around = |c: u32| fan(&twin, c).collect::<vec::Vec<_>>();
            assert_eq!(around(5), if count == 4 { vec![5, 8, 9, 0] } else { vec![0, 5, 8] });
            assert_eq!(around(4), [6, 4], "a border vertex, from its middle corner");
        }
    }

    #[test]
    fn one_byte_less_is_refused() {
        let mesh = MeshView { positions: &[DVec3::ZERO; 3], faces: &[[0, 1, 2]] };
        let mut bytes = vec![0u8; twins_need(1) - 1];
        assert!(twins(&mut [0; 3], mesh, Scratch::new(&mut bytes)).is_err());
    }
}
