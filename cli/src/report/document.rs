//! The JSON report of a run: what went in, what was asked, what came out, and how long it took.
//!
//! Times differ from run to run; everything else is the same for the same input, settings and seed.

use crate::args::line::Method;
use crate::figures::record::AtlasRecord;
use crate::formats::loaded::Loaded;
use crate::run::atlas::Atlas;
use crate::run::parts::PartReport;
use crate::run::progress::StageTime;
use crate::training::trainer::Trainer;
use seamwright_core::learn::losses::Loss;
use seamwright_core::mesh::repair;
use seamwright_core::pipeline::{Charts, Packing, Settings};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// The report. Figures that are not finite become null.
#[derive(Debug, Serialize)]
pub struct Report {
    /// Version of seamwright.
    pub version: &'static str,
    /// What was read.
    pub input: InputReport,
    /// The OBJ that was written.
    pub output: String,
    /// What was asked.
    pub settings: SettingsReport,
    /// What came out, in core's own figures.
    pub result: ResultReport,
    /// Parts and their charts, where the mesh was cut into parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<PartReport>>,
    /// How maps were trained, where they were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning: Option<LearningReport>,
    /// The figures of `seamwright measure`, over the run's own exposure.
    pub metrics: Option<AtlasRecord>,
    /// Time of each stage.
    pub stages: Vec<StageReport>,
    /// Time from start to the written atlas.
    pub seconds: f64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// How maps were trained.
#[derive(Debug, Serialize)]
pub struct LearningReport {
    /// Name of the preset; `given` where maps came from a file.
    pub preset: String,
    /// Width of hidden layers.
    pub width: usize,
    /// Width of codes.
    pub code: usize,
    /// Points of a batch; 0 is all.
    pub batch: usize,
    /// Whether training started from the exact stages' charts.
    pub start: bool,
    /// Weight of each loss.
    pub weights: BTreeMap<&'static str, f64>,
    /// Maps that were trained or given.
    pub maps: usize,
    /// Steps of all of them.
    pub steps: usize,
    /// Whether training was stopped before its end.
    pub was_stopped: bool,
    /// Faces that a map tears or folds and that were laid down beside others.
    pub torn_faces: usize,
    /// Faces that a map turns over.
    pub folded_faces: usize,
    /// Steps at which the losses of the largest piece were looked at.
    pub curve_steps: Vec<usize>,
    /// Its losses at these steps, unweighted, of those that were on; `visibility` is the exposure of seams.
    pub curves: BTreeMap<&'static str, Vec<f32>>,
}

impl LearningReport {
    /// What `trainer` was asked and did.
    pub fn new(trainer: &Trainer) -> Self {
        let (settings, summary) = (&trainer.settings, trainer.summary);
        let on = Loss::ALL.into_iter().filter(|loss| settings.weights.0[*loss as usize] != 0.0);
        let curve = |loss: Loss| trainer.samples().iter().map(|s| s.losses[loss as usize]).collect();
        Self {
            preset: trainer.preset.clone(),
            width: settings.widths.hidden,
            code: settings.widths.code,
            batch: settings.batch,
            start: trainer.start,
            weights: Loss::ALL.into_iter().map(|l| (l.name(), settings.weights.0[l as usize])).collect(),
            maps: summary.maps,
            steps: summary.steps,
            was_stopped: summary.was_stopped,
            torn_faces: summary.torn.faces,
            folded_faces: summary.torn.folded,
            curve_steps: trainer.samples().iter().map(|s| s.step).collect(),
            curves: on.map(|loss| (loss.name(), curve(loss))).collect(),
        }
    }
}

/// What was read.
#[derive(Debug, Serialize)]
pub struct InputReport {
    /// Path as given.
    pub file: String,
    /// Vertices of the file, merged or not.
    pub vertices: usize,
    /// Polygons of three or more corners.
    pub polygons: usize,
    /// Corners of these polygons.
    pub corners: usize,
    /// Whether it had UVs.
    pub has_uv: bool,
}

/// What was asked.
#[derive(Debug, Serialize)]
#[expect(missing_docs, reason = "the names are the command line's")]
pub struct SettingsReport {
    pub method: &'static str,
    pub distortion: f64,
    pub charts: &'static str,
    pub packing: &'static str,
    pub size: u32,
    pub padding: u32,
    pub rays: u32,
    pub seed: u64,
    pub parts: String,
    pub keep_seams: bool,
    pub threads: usize,
}

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
    /// What was repaired in the working copy.
    pub repaired: RepairReport,
}

/// What was repaired in the working copy; the file keeps all of it. Core says what each count means.
#[derive(Debug, Serialize)]
#[expect(missing_docs, reason = "the names are core's, see its repair::Summary")]
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

/// Time of a stage.
#[derive(Debug, Serialize)]
pub struct StageReport {
    /// Its name.
    pub stage: &'static str,
    /// Wall time, all visits together.
    pub seconds: f64,
}

impl From<&StageTime> for StageReport {
    fn from(time: &StageTime) -> Self {
        Self { stage: time.stage, seconds: time.time.as_secs_f64() }
    }
}

impl InputReport {
    /// What was read.
    pub fn new(loaded: &Loaded) -> Self {
        let mesh = loaded.mesh();
        Self {
            file: loaded.path.display().to_string(),
            vertices: mesh.positions.len(),
            polygons: mesh.polygon_count(),
            corners: mesh.corners.len(),
            has_uv: mesh.corner_uv.is_some(),
        }
    }
}

impl SettingsReport {
    /// What was asked.
    pub fn new(method: Method, settings: &Settings, keep_seams: bool, threads: usize) -> Self {
        Self {
            method: method.name(),
            distortion: settings.distortion,
            charts: match settings.charts {
                Charts::Few => "few",
                Charts::One => "one",
            },
            packing: match settings.packing {
                Packing::Tight => "tight",
                Packing::Grid => "grid",
            },
            size: settings.size,
            padding: settings.padding,
            rays: settings.rays,
            seed: settings.seed,
            parts: "off".into(),
            keep_seams,
            threads,
        }
    }
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
            ("edges cut because they have more than two faces or faces of opposite sides", repaired.split_edges),
        ];
        told.iter().filter(|(_, count)| *count > 0).map(|(text, count)| format!("{text}: {count}")).collect()
    }
}

impl From<&repair::Summary> for RepairReport {
    fn from(summary: &repair::Summary) -> Self {
        let repair::Summary {
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

impl Report {
    /// Writes indented JSON and a line end.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        out.write_all(b"\n")
    }
}
