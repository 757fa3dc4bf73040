//! The contact sheet of a polygon mesh as a file has it, as the bytes of a PNG.
//!
//! Polygons are drawn by the triangles that `measure` goes by: what the picture shows as flipped or overlapping is what it
//! counts.

use super::sheet::{SheetOptions, sheet};
use super::surface::PictureMesh;
use crate::mesh::polygons::Mesh;
use crate::mesh::triangles::of_mesh;
use glam::DVec2;
use seamwright_core::base::workers::Workers;

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
        let found = of_mesh(mesh);
        let corners: Vec<[u32; 3]> = found.iter().map(|(_, triangle)| *triangle).collect();
        let triangles: Vec<_> = corners.iter().map(|t| t.map(|c| mesh.corners[c as usize])).collect();
        let uv: Vec<_> = corners.iter().map(|t| t.map(|c| self.corner_uv[c as usize])).collect();
        let chart: Option<Vec<_>> = self.polygon_chart.map(|chart| found.iter().map(|(p, _)| chart[*p]).collect());
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
