//! Vertex normals of a triangle mesh.
//!
//! Each face adds its unit normal to its corners' vertices, weighted by the corner's angle (Thuermer, Wuethrich 1998:
//! the result does not depend on how a flat polygon is triangulated) or by the face's area (libigl's default).
//! Sums run over faces in order. A face without area adds nothing.

use super::view::MeshView;
use crate::base::real;
use glam::DVec3;

/// Weights of the faces around a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalWeight {
    /// The angle of the face's corner.
    #[default]
    Angle,
    /// The face's area.
    Area,
}

/// Fills `normals` with unit vectors; +z where the faces around a vertex cancel, have no area, or are none. O(f).
pub fn vertex_normals(normals: &mut [DVec3], mesh: MeshView, weight: NormalWeight) {
    normals.fill(DVec3::ZERO);
    for (f, face) in mesh.faces.iter().enumerate() {
        let area = mesh.area_vector(f);
        let Some(normal) = unit(area) else { continue };
        for i in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|k| mesh.positions[face[(i + k) % 3] as usize]);
            normals[face[i] as usize] += match weight {
                NormalWeight::Area => area,
                NormalWeight::Angle => normal * angle(q - p, r - p),
            };
        }
    }
    normals.iter_mut().for_each(|n| *n = unit(*n).unwrap_or(DVec3::Z));
}

/// The angle between two vectors, in [0, pi].
pub fn angle(u: DVec3, v: DVec3) -> f64 {
    let c = u.cross(v);
    real::atan2(real::sqrt(c.dot(c)), u.dot(v))
}

fn unit(v: DVec3) -> Option<DVec3> {
    let length = real::sqrt(v.dot(v));
    (length > 0.0 && length < f64::INFINITY).then(|| v / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube's corner at the origin, its z face cut in two triangles, the others in one.
    const POSITIONS: [DVec3; 5] = [
        DVec3::ZERO,
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(0.0, 1.0, 0.0),
        DVec3::new(0.0, 0.0, -1.0),
    ];
    const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];

    #[test]
    fn a_cubes_corner_points_along_its_diagonal_however_it_is_cut() {
        let mut normals = [DVec3::ZERO; 5];
        let mesh = MeshView { positions: &POSITIONS, faces: &FACES };
        vertex_normals(&mut normals, mesh, NormalWeight::Angle);
        let diagonal = DVec3::new(-1.0, -1.0, 1.0) / real::sqrt(3.0);
        assert!(normals[0].distance(diagonal) < 1e-15);
        vertex_normals(&mut normals, mesh, NormalWeight::Area);
        assert!(normals[0].distance(DVec3::new(-1.0, -1.0, 2.0) / real::sqrt(6.0)) < 1e-15);
    }

    #[test]
    fn a_vertex_without_area_around_it_points_up() {
        let mut normals = [DVec3::ZERO; 5];
        vertex_normals(&mut normals, MeshView { positions: &POSITIONS, faces: &[[0, 1, 1]] }, NormalWeight::Angle);
        assert_eq!(normals, [DVec3::Z; 5]);
    }
}
