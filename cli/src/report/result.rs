//! What came out, for the report, and what the user should know of it.

use crate::args::settings::work_words;
use crate::base::counted::counted;
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
    /// Texels that charts keep from each other.
    pub padding: f64,
    /// Faces that are not counter-clockwise in UV.
    pub flipped: usize,
    /// Faces that overlap another in UV.
    pub overlapping: usize,
    /// Charts that lie on others on purpose.
    pub stacked: usize,
    /// Edges that are cut though a weight forbids it.
    pub forbidden_cuts: usize,
    /// Closed cracks that are cut all the same, since the shading breaks there.
    pub closed_breaks: usize,
    /// What was repaired in the working copy.
    pub repaired: RepairReport,
    /// Where stages ended early, as `--work` takes it.
    pub ended_early: Option<String>,
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
    pub damaged_polygons: usize,
    pub flat_faces: usize,
    pub flipped_faces: usize,
    pub split_edges: usize,
    pub copied_edges: usize,
    pub one_sided_edges: usize,
    pub split_vertices: usize,
    pub components: usize,
    pub boundary_loops: usize,
    pub euler: i64,
    pub genus: i64,
    pub border_edges: usize,
    pub closed_edges: usize,
    pub weld_tolerance: f64,
    pub crack_width: f64,
}

impl ResultReport {
    /// What came out.
    pub fn new(atlas: &Atlas) -> Self {
        let report = &atlas.report;
        Self {
            charts: report.chart_count,
            distortion: report.distortion,
            utilisation: report.utilisation,
            padding: report.padding,
            flipped: report.flipped,
            overlapping: report.overlapping,
            stacked: report.stacked,
            forbidden_cuts: report.forbidden_cuts,
            closed_breaks: report.closed_breaks,
            repaired: RepairReport::from(&report.repaired),
            ended_early: report.ended_early.map(work_words),
        }
    }

    /// What was closed, where that was asked for.
    pub fn welded(&self) -> String {
        let RepairReport { border_edges, closed_edges, weld_tolerance, .. } = self.repaired;
        let left = border_edges.saturating_sub(2 * closed_edges);
        let breaks = match self.closed_breaks {
            0 => String::new(),
            1 => "; 1 stays cut, since the shading breaks there".into(),
            count => format!("; {count} stay cut, since the shading breaks there"),
        };
        format!(
            "cracks closed: {} within {weld_tolerance:.1e} of the diagonal, border edges {border_edges} -> {left}{breaks}",
            counted(closed_edges, "edge")
        )
    }

    /// What the user should know of the atlas: a count, its one cause, and what to do. Nothing where all is well.
    pub fn warnings(&self) -> Vec<String> {
        let repaired = &self.repaired;
        let crowded = repaired.split_edges.saturating_sub(repaired.copied_edges + repaired.one_sided_edges);
        let told = [
            (self.flipped, "faces turned over or without area in UV", "look at them in --sheet"),
            (self.overlapping, "faces that overlap another in UV", "presets other than paper have none"),
            (
                self.forbidden_cuts,
                "edges cut though their weight forbids it, since a piece cannot be laid flat without",
                "allow a cut there",
            ),
            (
                repaired.flipped_faces,
                "triangles that face the other way than their neighbours",
                "they are unwrapped with them and stay as they are in the file; turn them there if shading shows them",
            ),
            (
                repaired.dropped_polygons,
                "polygons without area, whose UVs are a neighbour's",
                "remove them if a UV at each corner is needed",
            ),
            (
                repaired.damaged_polygons,
                "polygons that name the same corners again and again, of which one ring is unwrapped",
                "build them anew",
            ),
            (crowded, "edges cut because more than two faces meet there", "remove faces inside, or part what touches"),
            (repaired.copied_edges, "edges cut because a face lies upon its copy there", "remove one of the two"),
            (
                repaired.one_sided_edges,
                "edges cut because the surface has one side only, like a Moebius band",
                "nothing needs to be done",
            ),
        ];
        let told = told.into_iter().filter(|(count, ..)| *count > 0);
        told.map(|(count, cause, advice)| format!("{cause}: {count}; {advice}")).collect()
    }
}

impl From<&RepairSummary> for RepairReport {
    fn from(summary: &RepairSummary) -> Self {
        let RepairSummary {
            welded_vertices,
            dropped_triangles,
            dropped_polygons,
            damaged_polygons,
            flat_faces,
            flipped_faces,
            split_edges,
            copied_edges,
            one_sided_edges,
            split_vertices,
            components,
            boundary_loops,
            euler,
            genus,
            border_edges,
            closed_edges,
            weld_tolerance,
            crack_width,
        } = *summary;
        Self {
            welded_vertices,
            dropped_triangles,
            dropped_polygons,
            damaged_polygons,
            flat_faces,
            flipped_faces,
            split_edges,
            copied_edges,
            one_sided_edges,
            split_vertices,
            components,
            boundary_loops,
            euler,
            genus,
            border_edges,
            closed_edges,
            weld_tolerance,
            crack_width,
        }
    }
}
