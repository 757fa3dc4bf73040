//! What came out, for the report, and what the user should know of it.

use crate::figures::record::AtlasRecord;
use crate::run::atlas::Atlas;
use seamwright_core::mesh::repair::RepairSummary;
use serde::Serialize;

/// What came out.
#[derive(Debug, Serialize)]
pub struct ResultReport {
    /// Charts.
    pub charts: usize,
    /// Mean symmetric Dirichlet energy over 4.
    pub distortion: f64,
    /// Share of the unit square that charts cover.
    pub utilisation: f64,
    /// Faces that are not counter-clockwise in UV.
    pub flipped: usize,
    /// Faces that overlap another in UV.
    pub overlapping: usize,
    /// Edges that are cut though a weight forbids it.
    pub forbidden_cuts: usize,
    /// What was repaired in the working copy.
    pub repaired: RepairReport,
}

/// One of several atlases.
#[derive(Debug, Serialize)]
pub struct SetReport {
    /// Its object's name; empty where it has none.
    pub name: String,
    /// Polygons.
    pub faces: usize,
    /// What came out.
    pub result: ResultReport,
    /// The figures of `seamwright measure`, over the run's own exposure.
    pub metrics: Option<AtlasRecord>,
}

/// What was repaired in the working copy; the file keeps all of it. Core says what each count means.
#[derive(Debug, Serialize)]
#[expect(missing_docs, reason = "the names are core's, see its RepairSummary")]
pub struct RepairReport {
    pub welded_vertices: usize,
    pub dropped_triangles: usize,
    pub dropped_polygons: usize,
    pub flat_faces: usize,
    pub flipped_faces: usize,
    pub split_edges: usize,
    pub split_vertices: usize,
    pub components: usize,
    pub boundary_loops: usize,
    pub euler: i64,
    pub genus: i64,
}

impl ResultReport {
    /// What came out.
    pub fn new(atlas: &Atlas) -> Self {
        let report = &atlas.report;
        Self {
            charts: report.chart_count,
            distortion: report.distortion,
            utilisation: report.utilisation,
            flipped: report.flipped,
            overlapping: report.overlapping,
            forbidden_cuts: report.forbidden_cuts,
            repaired: RepairReport::from(&report.repaired),
        }
    }

    /// What the user should know of the atlas; nothing where all is well.
    pub fn warnings(&self) -> Vec<String> {
        let repaired = &self.repaired;
        let told = [
            ("faces that are flipped or have no area in UV", self.flipped),
            ("faces that overlap another in UV", self.overlapping),
            ("polygons without three different corners, whose UVs are a neighbour's", repaired.dropped_polygons),
            (
                "edges cut though their weight forbids it, since a piece cannot be laid flat without",
                self.forbidden_cuts,
            ),
            ("edges cut because they have more than two faces or faces of opposite sides", repaired.split_edges),
        ];
        told.iter().filter(|(_, count)| *count > 0).map(|(text, count)| format!("{text}: {count}")).collect()
    }
}

impl From<&RepairSummary> for RepairReport {
    fn from(summary: &RepairSummary) -> Self {
        let RepairSummary {
            welded_vertices,
            dropped_triangles,
            dropped_polygons,
            flat_faces,
            flipped_faces,
            split_edges,
            split_vertices,
            components,
            boundary_loops,
            euler,
            genus,
        } = *summary;
        Self {
            welded_vertices,
            dropped_triangles,
            dropped_polygons,
            flat_faces,
            flipped_faces,
            split_edges,
            split_vertices,
            components,
            boundary_loops,
            euler,
            genus,
        }
    }
}
