//! The shape of each component in numbers: boundary loops, Euler characteristic, genus.
//!
//! For an oriented 2-manifold with boundary, as `repair` makes it: `twin` symmetric, one fan of corners a vertex.

use super::topology::vertex_corners;
use super::view::{NONE, next};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use bytemuck::{Pod, Zeroable};

/// How many half-edges lie on the border.
pub fn border_count(twin: &[u32]) -> usize {
    twin.iter().filter(|t| **t == NONE).count()
}

/// The border half-edge that begins where border half-edge `h` ends.
pub fn next_on_border(twin: &[u32], h: u32) -> u32 {
    let mut at = next(h);
    while twin[at as usize] != NONE {
        at = next(twin[at as usize]);
    }
    at
}

/// Scratch bytes for [`boundary_loops`] on a mesh of `faces` triangles.
pub const fn boundary_loops_need(faces: usize) -> usize {
    bytes_for::<u8>(3 * faces)
}

/// Walks the border: `order` (as many as [`border_count`] says) lists its half-edges loop after loop, each loop from
/// its lowest half-edge on, each half-edge beginning where the one before it ends, with the surface to the left.
/// `start` (one more than that count) gets the first place of each loop, and then the number of half-edges. Returns
/// the number of loops, which come in the order of their lowest half-edges. O(f).
pub fn boundary_loops(
    order: &mut [u32],
    start: &mut [u32],
    twin: &[u32],
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    scratch.require(boundary_loops_need(twin.len() / 3))?;
    let done = scratch.take::<u8>(twin.len())?;
    let (mut loops, mut end) = (0, 0);
    for first in (0..twin.len()).filter(|h| twin[*h] == NONE) {
        if done[first] != 0 {
            continue;
        }
        start[loops] = end as u32;
        loops += 1;
        walk(twin, done, first as u32, |h| {
            order[end] = h;
            end += 1;
        });
    }
    start[loops] = end as u32;
    Ok(loops)
}

/// How many loops the border has; `done` is zero, one entry a half-edge.
pub fn count_loops(twin: &[u32], done: &mut [u8]) -> usize {
    let mut loops = 0;
    for h in (0..twin.len()).filter(|h| twin[*h] == NONE) {
        loops += usize::from(done[h] == 0);
        walk(twin, done, h as u32, |_| ());
    }
    loops
}

/// Visits the loop of border half-edge `first` from there on, as far as it is not `done`, which it is afterwards.
fn walk(twin: &[u32], done: &mut [u8], first: u32, mut visit: impl FnMut(u32)) {
    let mut at = first;
    while core::mem::replace(&mut done[at as usize], 1) == 0 {
        visit(at);
        at = next_on_border(twin, at);
    }
}

/// A component in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ComponentShape {
    /// Vertices.
    pub vertices: u32,
    /// Edges, those on the border included.
    pub edges: u32,
    /// Triangles.
    pub faces: u32,
    /// Closed curves that the border consists of.
    pub loops: u32,
}

impl ComponentShape {
    /// V - E + F: 2 for a sphere, 1 for a disk, 0 for a torus or an open cylinder.
    pub fn euler(&self) -> i64 {
        i64::from(self.vertices) - i64::from(self.edges) + i64::from(self.faces)
    }

    /// Handles: (2 - loops - euler) / 2.
    pub fn genus(&self) -> i64 {
        (2 - i64::from(self.loops) - self.euler()) / 2
    }

    /// One component that a disk's map fits on: no handle, one loop.
    pub fn is_disk(&self) -> bool {
        self.loops == 1 && self.euler() == 1
    }
}

/// Scratch bytes for [`shapes`] on a mesh of `faces` triangles and `vertices` vertices.
pub const fn shapes_need(faces: usize, vertices: usize) -> usize {
    bytes_for::<u8>(3 * faces).saturating_add(bytes_for::<u32>(vertices))
}

/// Fills `shape` (one entry a component) from faces, twins, each face's `component` and the number of vertices. O(f).
pub fn shapes(
    shape: &mut [ComponentShape],
    faces: &[[u32; 3]],
    twin: &[u32],
    component: &[u32],
    vertex_count: usize,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    scratch.require(shapes_need(faces.len(), vertex_count))?;
    shape.fill(ComponentShape::default());
    let corner = scratch.take::<u32>(vertex_count)?;
    vertex_corners(corner, faces);
    for &c in corner.iter().filter(|c| **c != NONE) {
        shape[component[(c / 3) as usize] as usize].vertices += 1;
    }
    let done = scratch.take::<u8>(twin.len())?;
    for (h, &t) in twin.iter().enumerate() {
        let shape = &mut shape[component[h / 3] as usize];
        shape.faces += u32::from(h % 3 == 0);
        shape.edges += u32::from(t == NONE || (h as u32) < t);
        if t == NONE && done[h] == 0 {
            shape.loops += 1;
            walk(twin, done, h as u32, |_| ());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::{twins, twins_need};
    use crate::mesh::view::MeshView;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    fn twins_of(faces: &[[u32; 3]], vertices: usize) -> Vec<u32> {
        let positions = vec![DVec3::ZERO; vertices];
        let mut twin = vec![0; 3 * faces.len()];
        let mut bytes = vec![0u8; twins_need(faces.len())];
        let bad = twins(&mut twin, MeshView { positions: &positions, faces }, Scratch::new(&mut bytes));
        assert_eq!(bad, Ok(0));
        twin
    }

    fn shape_of(faces: &[[u32; 3]], vertices: usize) -> ComponentShape {
        let mut shape = [ComponentShape::default()];
        let mut bytes = vec![0u8; shapes_need(faces.len(), vertices)];
        let twin = twins_of(faces, vertices);
        shapes(&mut shape, faces, &twin, &vec![0; faces.len()], vertices, Scratch::new(&mut bytes)).unwrap();
        shape[0]
    }

    /// Two triangles a cell of an n x m grid that closes in both directions, or only in the first.
    fn grid(n: u32, m: u32, closed: bool) -> Vec<[u32; 3]> {
        let at = |i: u32, j: u32| (i % n) + n * if closed { j % m } else { j };
        let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
        cells
            .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]])
            .collect()
    }

    #[test]
    fn a_tetrahedron_is_a_sphere_a_triangle_a_disk_a_closed_grid_a_torus() {
        let tetrahedron = shape_of(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], 4);
        assert_eq!((tetrahedron.euler(), tetrahedron.genus(), tetrahedron.loops), (2, 0, 0));
        assert!(shape_of(&[[0, 1, 2]], 3).is_disk());
        let torus = shape_of(&grid(4, 5, true), 20);
        assert_eq!((torus.euler(), torus.genus(), torus.loops), (0, 1, 0));
        let cylinder = shape_of(&grid(4, 5, false), 24);
        assert_eq!((cylinder.euler(), cylinder.genus(), cylinder.loops), (0, 0, 2));
    }

    #[test]
    fn loops_follow_the_border_end_to_start() {
        let faces = grid(4, 2, false);
        let twin = twins_of(&faces, 12);
        let count = border_count(&twin);
        let (mut order, mut start) = (vec![0; count], vec![0; count + 1]);
        let mut bytes = vec![0u8; boundary_loops_need(faces.len())];
        let loops = boundary_loops(&mut order, &mut start, &twin, Scratch::new(&mut bytes)).unwrap();
        assert_eq!((loops, &start[..3]), (2, &[0, 4, 8][..]));
        for border in [&order[..4], &order[4..]] {
            for i in 0..4 {
                let (h, after) = (border[i], border[(i + 1) % 4]);
                let vertex = |c: u32| faces.as_flattened()[c as usize];
                assert_eq!(vertex(next(h)), vertex(after));
            }
        }
    }

    #[test]
    fn a_closed_surface_has_no_loop_and_no_mesh_has_no_shape() {
        let twin = twins_of(&grid(3, 3, true), 9);
        let mut bytes = vec![0u8; 128];
        assert_eq!(boundary_loops(&mut [], &mut [7], &twin, Scratch::new(&mut bytes)), Ok(0));
        assert_eq!(shapes(&mut [], &[], &[], &[], 0, Scratch::new(&mut bytes)), Ok(()));
    }

    #[test]
    fn one_byte_less_is_refused() {
        let twin = [NONE; 3];
        let mut bytes = vec![0u8; boundary_loops_need(1) - 1];
        assert!(boundary_loops(&mut [0; 3], &mut [0; 4], &twin, Scratch::new(&mut bytes)).is_err());
        let mut bytes = vec![0u8; shapes_need(1, 3) - 1];
        let mut shape = [ComponentShape::default()];
        assert!(shapes(&mut shape, &[[0, 1, 2]], &twin, &[0], 3, Scratch::new(&mut bytes)).is_err());
    }
}
