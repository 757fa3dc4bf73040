//! The JSON report of a run that carried an atlas from one mesh to another.

use super::asked::InputReport;
use super::document::StageReport;
use crate::base::counted::counted;
use crate::formats::loaded::Loaded;
use seamwright_core::transfer::report::TransferReport as Done;
use serde::Serialize;

/// The report.
#[derive(Debug, Serialize)]
pub struct CarriedReport {
    /// Version of seamwright.
    pub version: &'static str,
    /// The mesh with the atlas.
    pub source: InputReport,
    /// The mesh that it went to.
    pub input: InputReport,
    /// The file that was written.
    pub output: String,
    /// Side of the texture by which texels are counted.
    pub size: u32,
    /// What came out.
    pub result: CarriedResult,
    /// Time of each stage.
    pub stages: Vec<StageReport>,
    /// Time from start to the written atlas.
    pub seconds: f64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// What came out.
#[derive(Debug, Serialize)]
pub struct CarriedResult {
    /// Share of the surface whose UVs are within two texels of the source's.
    pub within_two_texels: f64,
    /// Charts of the source.
    pub source_charts: usize,
    /// Those of them that the mesh has.
    pub charts: usize,
    /// Connected regions that they are on the mesh.
    pub regions: usize,
    /// Flipped faces.
    pub flipped_faces: usize,
    /// Faces that overlap another.
    pub overlapping_faces: usize,
    /// Faces that could not stay where the source has them.
    pub moved_faces: usize,
    /// Mean distance of the two surfaces.
    pub distance: f64,
    /// Whether all its polygons are polygons of the source, and the UVs were copied.
    pub copied: bool,
}

impl From<&Done> for CarriedResult {
    fn from(done: &Done) -> Self {
        Self {
            within_two_texels: done.within_two_texels,
            source_charts: done.source_charts,
            charts: done.charts,
            regions: done.regions,
            flipped_faces: done.flipped,
            overlapping_faces: done.overlapping,
            moved_faces: done.moved,
            distance: done.distance,
            copied: done.copied,
        }
    }
}

/// Share of the surface within two texels below which the user is told.
const LITTLE: f64 = 0.9;

/// What the user should know of the source and of what came out.
pub fn warnings(source: &Loaded, mesh: &Loaded, done: &Done) -> Vec<String> {
    let (from, onto) = (source.path.display(), mesh.path.display());
    let mut all = Vec::new();
    if done.source_flipped > 0 {
        let here = if done.copied { "as they were" } else { "not" };
        all.push(format!("{from}: {} faces of its atlas are flipped; here they are {here}", done.source_flipped));
    }
    if done.source_overlapping > 0 {
        all.push(format!("{from}: {} faces of its atlas overlap", done.source_overlapping));
    }
    if done.within_two_texels < LITTLE {
        let share = 100.0 * done.within_two_texels;
        all.push(format!("{onto}: {share:.1} % of its surface keeps its texels; the texture does not fit the rest"));
    }
    let (had, has) = (done.source_charts, done.charts);
    if has < had && !done.copied {
        all.push(format!(
            "{onto}: {} of {had} charts have none of its faces: it lacks what they cover, or its faces are larger",
            had - has
        ));
    }
    if done.regions > has {
        all.push(format!(
            "{onto}: its {} lie in {}, where its faces are larger than a chart is wide",
            counted(has, "chart"),
            counted(done.regions, "piece")
        ));
    }
    all
}
