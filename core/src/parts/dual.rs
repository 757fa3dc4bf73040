//! The dual graph of a mesh: a node a face, an edge where two faces meet, with the edge's length and turn.
//!
//! The turn is the signed angle between the normals of the two faces: 0 flat, above 0 convex, below 0 concave, in
//! [-pi, pi]. A face without area has no normal: its turns are 0.

use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::{MeshView, NONE, next};

/// Edges between faces, by the lower of their two half-edges.
pub struct Dual<'a> {
    /// The two faces of each edge; the first has the lower half-edge.
    pub sides: &'a [[u32; 2]], // (e)
    /// Length of each edge.
    pub length: &'a [f64], // (e)
    /// Signed angle between the two normals.
    pub turn: &'a [f64], // (e)
    /// Area of each face.
    pub area: &'a [f64], // (f)
}

/// Bytes that [`Dual::new`] takes for `faces` triangles.
pub const fn dual_need(faces: usize) -> usize {
    bytes_for::<[u32; 2]>(faces + faces / 2 + 1) + 2 * bytes_for::<f64>(faces + faces / 2 + 1) + bytes_for::<f64>(faces)
}

impl<'a> Dual<'a> {
    /// The dual graph of a mesh with the given twins. O(f).
    pub fn new(mesh: MeshView, twin: &[u32], scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let is_edge = |c: u32| twin[c as usize] != NONE && c < twin[c as usize];
        let count = (0..twin.len() as u32).filter(|c| is_edge(*c)).count();
        let sides = scratch.take::<[u32; 2]>(count)?;
        let length = scratch.take::<f64>(count)?;
        let turn = scratch.take::<f64>(count)?;
        let area = scratch.take::<f64>(mesh.faces.len())?;
        for (f, area) in area.iter_mut().enumerate() {
            *area = 0.5 * real::sqrt(mesh.area_vector(f).length_squared());
        }
        for (e, c) in (0..twin.len() as u32).filter(|c| is_edge(*c)).enumerate() {
            let faces = [c / 3, twin[c as usize] / 3];
            let along = mesh.position(next(c)) - mesh.position(c);
            let [m, n] = faces.map(|f| mesh.area_vector(f as usize));
            let across = m.cross(n);
            let angle = real::atan2(real::sqrt(across.length_squared()), m.dot(n));
            sides[e] = faces;
            length[e] = real::sqrt(along.length_squared());
            turn[e] = if across.dot(along) < 0.0 { -angle } else { angle };
        }
        Ok(Self { sides, length, turn, area })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f64::consts::FRAC_PI_2;
    use glam::DVec3;
    use std::vec;

    #[test]
    fn a_ridge_turns_up_and_a_valley_down() {
        // Two triangles along the y axis: the second falls away from the plane z = 0, or rises over it.
        for (z, turn) in [(-1.0, FRAC_PI_2), (1.0, -FRAC_PI_2), (0.0, 0.0)] {
            let x = if z == 0.0 { 1.0 } else { 0.0 };
            let positions = [DVec3::ZERO, DVec3::Y * 2.0, DVec3::NEG_X, DVec3::new(x, 0.0, z)];
            let mesh = MeshView { positions: &positions, faces: &[[0, 1, 2], [1, 0, 3]] };
            let mut bytes = vec![0; dual_need(2)];
            let dual = Dual::new(mesh, &[3, NONE, NONE, 0, NONE, NONE], &mut Scratch::new(&mut bytes)).unwrap();
            assert_eq!((dual.sides, dual.length), (&[[0, 1]][..], &[2.0][..]));
            assert_abs_diff_eq!(dual.turn[0], turn, epsilon = 1e-15);
            assert_eq!(dual.area, [1.0, 1.0]);
        }
    }

    #[test]
    fn a_face_without_area_is_flat_and_one_byte_less_is_refused() {
        let mesh = MeshView { positions: &[DVec3::ZERO; 4], faces: &[[0, 1, 2], [1, 0, 3]] };
        let twin = [3, NONE, NONE, 0, NONE, NONE];
        let mut bytes = vec![0; dual_need(2)];
        assert_eq!(Dual::new(mesh, &twin, &mut Scratch::new(&mut bytes)).unwrap().turn, [0.0]);
        assert!(Dual::new(mesh, &twin, &mut Scratch::new(&mut bytes[..30])).is_err());
    }
}
