//! The contact sheet of a polygon mesh as a file has it, as the bytes of a PNG.
//!
//! Polygons are drawn as fans from their first corner, the judge's convention: what the picture shows as flipped or
//! overlapping is what `measure` counts.

use super::sheet::{SheetOptions, sheet};
use super::surface::PictureMesh;
use crate::mesh::polygons::Mesh;
use glam::DVec2;
use seamwright_core::base::workers::Workers;
use seamwright_core::judge::input::fan;

/// What the sheet shows.
pub struct Drawing<'a> {
    /// Printed above.
    pub title: String,
    /// The mesh; its own UVs are not looked at.
    pub mesh: &'a Mesh,
    /// UV of each corner; not finite where there is none.
    pub corner_uv: &'a [DVec2], // (c)
    /// Chart of each polygon; found from the UVs where absent.
    pub polygon_chart: Option<&'a [u32]>, // (p)
    /// Exposure of each vertex; found by rays over the joined mesh where absent.
    pub exposure: Option<&'a [f32]>, // (n)
}

impl Drawing<'_> {
    /// Draws it. The same bytes with any workers.
    pub fn png(self, workers: &dyn Workers) -> Vec<u8> {
        let mesh = self.mesh;
        let corners: Vec<[u32; 3]> = fans(mesh).map(|(_, triangle)| triangle).collect();
        let triangles: Vec<_> = corners.iter().map(|t| t.map(|c| mesh.corners[c as usize])).collect();
        let uv: Vec<_> = corners.iter().map(|t| t.map(|c| self.corner_uv[c as usize])).collect();
        let chart: Option<Vec<_>> = self.polygon_chart.map(|chart| fans(mesh).map(|(p, _)| chart[p]).collect());
        let picture = PictureMesh {
            positions: &mesh.positions,
            triangles: &triangles,
            corner_uv: Some(&uv),
            chart: chart.as_deref(),
            exposure: self.exposure,
        };
        sheet(&picture, &SheetOptions { title: self.title, ..Default::default() }, workers).png()
    }
}

/// The triangles of every polygon, as its number and three corners.
pub(super) fn fans(mesh: &Mesh) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
    let ends = mesh.polygon_start.windows(2).enumerate();
    ends.flat_map(|(p, ends)| fan(ends[0], ends[1]).map(move |triangle| (p, triangle)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pentagon_is_three_triangles_of_its_polygon() {
        let mesh = Mesh { corners: (0..8).collect(), polygon_start: vec![0, 3, 8], ..Mesh::default() };
        let expected = [(0, [0, 1, 2]), (1, [3, 4, 5]), (1, [3, 5, 6]), (1, [3, 6, 7])];
        assert_eq!(fans(&mesh).collect::<Vec<_>>(), expected);
    }
}
