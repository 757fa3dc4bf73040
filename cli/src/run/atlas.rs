//! An atlas of a loaded mesh, by core's pipeline.

use super::errors::refusal;
use super::hierarchy::ObvhsBuilder;
use super::memory::with_enough;
use super::progress::Reporter;
use super::stop::{alarm, stop_requested};
use crate::args::method::MethodArg;
use crate::base::failure::Failure;
use crate::formats::loaded::Loaded;
use crate::mesh::polygons::Mesh;
use crate::training::trainer::Trainer;
use glam::DVec2;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::pipeline::learned::learned_need;
use seamwright_core::pipeline::learning::MOST;
use seamwright_core::pipeline::{Input, Method, Output, Report, Settings, unwrap_by, unwrap_need};
use seamwright_core::price::given::EdgeData;

/// A UV atlas of a mesh.
pub struct Atlas {
    /// UV of each corner, on a grid of 2^-24.
    pub corner_uv: Vec<DVec2>, // (c)
    /// Chart of each polygon.
    pub polygon_chart: Vec<u32>, // (p)
    /// Exposure of each vertex, 1 open.
    pub exposure: Vec<f32>, // (n)
    /// What was done.
    pub report: Report,
}

/// Makes the atlas of `loaded` with the exact method; see [`make_by`].
pub fn make(
    loaded: &Loaded,
    parts: Option<&[u32]>,
    keep_seams: bool,
    settings: &Settings,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<Atlas, Failure> {
    make_by(MethodArg::Exact, None, loaded, parts, keep_seams, settings, workers, progress)
}

/// Makes the atlas of `loaded`, with the borders of `parts` (one a polygon) as cuts where there are
/// any. With `keep_seams` the borders of its own UVs stay cuts.
#[allow(clippy::too_many_arguments)]
pub fn make_by(
    method: MethodArg,
    mut trainer: Option<&mut Trainer>,
    loaded: &Loaded,
    parts: Option<&[u32]>,
    keep_seams: bool,
    settings: &Settings,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<Atlas, Failure> {
    let mesh = loaded.polygons()?;
    if keep_seams && mesh.corner_uv.is_none() {
        let text = "the file has no UVs whose seams could be kept; leave the flag out";
        return Err(Failure::Input(format!("{}: --keep-seams: {text}", loaded.path.display())));
    }
    let input = input(mesh, keep_seams, parts);
    let mut atlas = empty(mesh);
    let triangles = mesh.corners.len().saturating_sub(2 * mesh.polygon_count());
    let learned = trainer.as_ref().map_or(0, |t| learned_need(triangles, mesh.positions.len(), &t.settings, MOST));
    let need = unwrap_need(&input, settings, &ObvhsBuilder).saturating_add(learned);
    let result = with_enough(need, |bytes| {
        let output = Output {
            corner_uv: &mut atlas.corner_uv,
            polygon_chart: &mut atlas.polygon_chart,
            exposure: &mut atlas.exposure,
        };
        let mut learning = trainer.as_mut().map(|trainer| trainer.learning());
        let by = match (method, &mut learning) {
            (MethodArg::Neural, Some(learning)) => Method::Neural(learning),
            (MethodArg::Hybrid, Some(learning)) => Method::Hybrid(learning),
            _ => Method::Exact,
        };
        let scratch = Scratch::with_alarm(bytes, alarm());
        let report = unwrap_by(by, output, &input, settings, &ObvhsBuilder, scratch, workers, progress);
        let summary = learning.map(|learning| learning.summary);
        if let (Some(trainer), Some(summary)) = (&mut trainer, summary) {
            trainer.summary = summary;
        }
        report
    })?;
    atlas.report = result.map_err(|e| refusal(loaded, e))?;
    if stop_requested() { Err(Failure::Stopped) } else { Ok(atlas) }
}

/// Bytes that core may need for `mesh`, an estimate from above.
pub fn need(mesh: &Mesh, settings: &Settings) -> usize {
    unwrap_need(&input(mesh, false, None), settings, &ObvhsBuilder)
}

fn input<'a>(mesh: &'a Mesh, keep_seams: bool, parts: Option<&'a [u32]>) -> Input<'a> {
    Input {
        kept_uv: mesh.corner_uv.as_deref().filter(|_| keep_seams),
        parts,
        edges: EdgeData {
            normals: mesh.corner_normals.as_deref(),
            marks: mesh.edge_marks.as_deref(),
            ..EdgeData::default()
        },
        tolerance: mesh.tolerance,
        ..Input::new(&mesh.positions, &mesh.corners, &mesh.polygon_start)
    }
}

fn empty(mesh: &Mesh) -> Atlas {
    Atlas {
        corner_uv: vec![DVec2::ZERO; mesh.corners.len()],
        polygon_chart: vec![0; mesh.polygon_count()],
        exposure: vec![0.0; mesh.positions.len()],
        report: Report::default(),
    }
}
