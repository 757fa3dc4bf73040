//! What the judge looks at: triangles in space with a UV at each of their corners.
//!
//! A triangle has UV when all six of its coordinates are finite; any other is left out of every UV figure and counted.
//! Polygons are judged by the triangles that an unwrap of them has, see [`triangles`](crate::mesh::triangles); as fans from their
//! first corner ([`fan`]) where those cannot be had.

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::plane::grid::grid_bits;
use glam::{DVec2, DVec3};

/// A UV-mapped triangle mesh. Nothing needs to be welded, oriented or manifold.
#[derive(Clone, Copy)]
pub struct UvMesh<'a> {
    /// Vertex positions.
    pub positions: &'a [DVec3], // (n)
    /// Vertices of each triangle, below n.
    pub triangles: &'a [[u32; 3]], // (f)
    /// UV of each corner; NaN where there is none.
    pub corner_uv: &'a [[DVec2; 3]], // (f)
}

/// Smallest box that holds the UVs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvBox {
    /// Lower corner.
    pub low: DVec2,
    /// Upper corner.
    pub high: DVec2,
}

impl UvBox {
    /// The longer side; 1 where all UVs are one point, so that it can divide.
    pub fn extent(&self) -> f64 {
        let side = (self.high - self.low).max_element();
        if side > 0.0 { side } else { 1.0 }
    }

    /// Of the finest grid that holds all of it; see [`grid_bits`].
    pub fn grid_bits(&self) -> i32 {
        grid_bits(self.low.abs().max(self.high.abs()).max_element())
    }
}

/// Areas of each triangle.
#[derive(Clone, Copy)]
pub struct Areas<'a> {
    /// Area in space.
    pub solid: &'a [f64], // (f)
    /// Signed area in UV, positive counter-clockwise; 0 without UV.
    pub uv: &'a [f64], // (f)
}

/// The corners (first, i, i + 1) of the triangles that a polygon with corners `first..end` is cut into.
pub fn fan(first: u32, end: u32) -> impl Iterator<Item = [u32; 3]> {
    (first.saturating_add(2)..end).map(move |c| [first, c - 1, c])
}

impl UvMesh<'_> {
    /// Whether all three corners of `face` have a UV.
    pub fn has_uv(&self, face: usize) -> bool {
        self.corner_uv[face].iter().all(|uv| uv.is_finite())
    }

    /// The three points of `face`.
    pub fn points(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|v| self.positions[v as usize])
    }

    /// Normal of `face`, as long as twice its area.
    pub fn normal(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.points(face);
        (b - a).cross(c - a)
    }

    /// Faces that have UV, in order.
    pub fn mapped_faces(&self) -> impl Iterator<Item = usize> {
        (0..self.triangles.len()).filter(|f| self.has_uv(*f))
    }

    /// The box of all UVs, or `None` where no face has any.
    pub fn uv_box(&self) -> Option<UvBox> {
        let corners = self.mapped_faces().flat_map(|f| self.corner_uv[f]);
        corners.fold(None, |sum: Option<UvBox>, uv| {
            let (low, high) = sum.map_or((uv, uv), |b| (b.low.min(uv), b.high.max(uv)));
            Some(UvBox { low, high })
        })
    }
}

/// Bytes that [`areas`] takes.
pub const fn areas_need(faces: usize) -> usize {
    bytes_for::<f64>(faces).saturating_mul(2)
}

/// The areas of all faces of `mesh`.
pub fn areas<'s>(mesh: UvMesh, scratch: &mut Scratch<'s>) -> Result<Areas<'s>, ScratchTooSmall> {
    let faces = mesh.triangles.len();
    scratch.require(areas_need(faces))?;
    let solid = scratch.take::<f64>(faces)?;
    let uv = scratch.take::<f64>(faces)?;
    for f in 0..faces {
        solid[f] = 0.5 * sqrt(mesh.normal(f).length_squared());
        if mesh.has_uv(f) {
            let [p, q, r] = mesh.corner_uv[f];
            uv[f] = 0.5 * (q - p).perp_dot(r - p);
        }
    }
    Ok(Areas { solid, uv })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_polygon_is_a_fan_from_its_first_corner() {
        assert_eq!(fan(4, 8).collect::<Vec<_>>(), [[4, 5, 6], [4, 6, 7]]);
        assert_eq!(fan(4, 6).count() + fan(4, 4).count() + fan(u32::MAX, u32::MAX).count(), 0);
    }

    #[test]
    fn a_face_with_one_missing_corner_has_no_uv() {
        let mesh = UvMesh {
            positions: &[DVec3::ZERO; 3],
            triangles: &[[0, 1, 2]],
            corner_uv: &[[DVec2::ZERO, DVec2::new(0.0, f64::NAN), DVec2::ONE]],
        };
        assert!(!mesh.has_uv(0) && mesh.uv_box().is_none());
    }
}
