//! The quads of a chart: pairs of its faces that a diagonal joins which is never cut.

use super::surface::Surface;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::mesh::view::{next, prev};
use crate::solve::quad::Quad;

/// Lists the convex quads among `faces`, which ascend; `triangles` are their nodes.
pub fn quads_of<'q>(
    faces: &[u32],
    triangles: &[[u32; 3]],
    surface: &Surface,
    cut: &[u8],
    keep: &mut Scratch<'q>,
) -> Result<&'q [Quad], ScratchTooSmall> {
    let quads = faces.iter().enumerate().filter_map(|(k, f)| {
        let c = first_half(*f, surface, cut)?;
        let t = surface.twin[c as usize];
        let l = faces.binary_search(&(t / 3)).ok()?;
        let corners = [c, prev(t), next(c), prev(c)];
        let node = |d: u32| triangles[if d / 3 == c / 3 { k } else { l }][(d % 3) as usize];
        Quad::new([k as u32, l as u32], corners.map(node), corners.map(|d| surface.mesh.position(d)))
    });
    let list = keep.fill::<Quad>(|out| {
        let mut count = 0;
        for quad in quads {
            *out.get_mut(count)? = quad;
            count += 1;
        }
        Some(count)
    })?;
    Ok(list)
}

/// The one diagonal of face `f`, where it is the first of the two faces of a quad.
fn first_half(f: u32, surface: &Surface, cut: &[u8]) -> Option<u32> {
    let c = diagonal(f, surface)?;
    let t = surface.across(cut, c).filter(|t| *t > c)?;
    (diagonal(t / 3, surface) == Some(t)).then_some(c)
}

/// The corner of face `f` whose edge must not be cut, where there is one and no other.
pub fn diagonal(f: u32, surface: &Surface) -> Option<u32> {
    let mut found = (3 * f..3 * f + 3).filter(|c| surface.cost.get(*c as usize) == Some(&f64::INFINITY));
    found.next().filter(|_| found.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::surface_tests::on_surface;
    use crate::mesh::view::MeshView;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// Nodes of the quads that a fan over these corners has whose diagonals to the corners of `held` must not be cut.
    fn found(corners: &[(f64, f64)], held: &[u32]) -> Vec<[u32; 4]> {
        let positions: Vec<DVec3> = corners.iter().map(|(x, y)| DVec3::new(*x, *y, 0.0)).collect();
        let faces: Vec<[u32; 3]> = (1..corners.len() as u32 - 1).map(|i| [0, i, i + 1]).collect();
        let is_held = |mesh: MeshView, c: u32| {
            let [low, high] = [mesh.vertex(c).min(mesh.vertex(next(c))), mesh.vertex(c).max(mesh.vertex(next(c)))];
            low == 0 && held.contains(&high)
        };
        let cost = |mesh: MeshView, c: u32| if is_held(mesh, c) { f64::INFINITY } else { 1.0 };
        on_surface(&positions, &faces, cost, |surface, mut keep| {
            let all: Vec<u32> = (0..faces.len() as u32).collect();
            let quads = quads_of(&all, &faces, surface, &vec![0; surface.twin.len()], &mut keep).unwrap();
            quads.iter().map(|q| q.nodes).collect()
        })
    }

    #[test]
    fn two_faces_on_a_diagonal_that_is_never_cut_are_a_quad() {
        let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
        let rings = found(&square, &[2]);
        // Round the square, from one end of the diagonal.
        assert!(rings == [[0, 1, 2, 3]] || rings == [[2, 3, 0, 1]], "{rings:?}");
        assert!(found(&square, &[]).is_empty(), "triangles are triangles");
        assert!(found(&[(0., 0.), (1., 0.), (0.3, 0.3), (0., 1.)], &[2]).is_empty(), "bent inwards");
    }

    #[test]
    fn polygons_of_more_corners_are_no_quads() {
        let house = [(0., 0.), (1., 0.), (1., 1.), (0.5, 1.5), (0., 1.)];
        assert!(found(&house, &[2, 3]).is_empty());
        assert_eq!(found(&house, &[2]).len(), 1, "a quad and a triangle beside it");
    }
}
