//! An atlas of a loaded mesh, by core's pipeline.

use super::errors::refusal;
use super::hierarchy::ObvhsBuilder;
use super::memory::with_enough;
use super::progress::Reporter;
use super::stop::{alarm, stop_requested};
use crate::base::failure::Failure;
use crate::formats::loaded::Loaded;
use crate::mesh::polygons::Mesh;
use crate::training::map_file::mesh_hash;
use crate::training::trainer::Trainer;
use glam::DVec2;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::pipeline::learning::MOST;
use seamwright_core::pipeline::neural::neural_need;
use seamwright_core::pipeline::published::published_need;
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
    make_by(None, loaded, parts, keep_seams, settings, workers, progress)
}

/// Makes the atlas of `loaded`, by a network where there is a `trainer`, with the borders of `parts` (one a polygon) as cuts where there are
/// any. With `keep_seams` the borders of its own UVs stay cuts.
#[allow(clippy::too_many_arguments)]
pub fn make_by(
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
    let learned = match &trainer {
        None => 0,
        Some(Trainer::Fit(fit)) => neural_need(triangles, &fit.settings),
        Some(Trainer::Published(of)) => published_need(triangles, mesh.positions.len(), &of.settings, MOST),
    };
    if let Some(Trainer::Fit(fit)) = &trainer
        && fit.given.is_some_and(|given| given != mesh_hash(mesh))
    {
        let text = "not the mesh that the map was learned of; `seamwright transfer` takes an atlas to another mesh";
        return Err(Failure::Input(format!("{}: {text}", loaded.path.display())));
    }
    let need = unwrap_need(&input, settings, &ObvhsBuilder).saturating_add(learned);
    let result = with_enough(need, |bytes| {
        let output = Output {
            corner_uv: &mut atlas.corner_uv,
            polygon_chart: &mut atlas.polygon_chart,
            exposure: &mut atlas.exposure,
        };
        let scratch = Scratch::with_alarm(bytes, alarm());
        let go = |by: Method| unwrap_by(by, output, &input, settings, &ObvhsBuilder, scratch, workers, progress);
        match trainer.as_deref_mut() {
            None => go(Method::Exact),
            Some(Trainer::Fit(fit)) => {
                let mut fitting = fit.fitting(triangles);
                let report = go(Method::Neural(&mut fitting));
                fit.summary = fitting.summary;
                report
            }
            Some(Trainer::Published(of)) => {
                let mut learning = of.learning();
                let report = go(Method::Published(&mut learning));
                of.summary = learning.summary;
                report
            }
        }
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
