//! One mesh through every stage: parts by shape diameter, an exact unwrap with its exposure, a short training, metrics.

use crate::figures;
use crate::hash::Hash;
use crate::mesh::{Mesh, read};
use core::fmt;
use glam::{DVec2, DVec3};
use seamwright_core::base::progress::Silent;
use seamwright_core::base::scratch::{Scratch, ScratchTooSmall};
use seamwright_core::base::workers::Workers;
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::measure::{MeasureError, measure};
use seamwright_core::learn::backbone::Widths;
use seamwright_core::learn::fit::{FitSample, FitSettings};
use seamwright_core::learn::kernels::path::Path;
use seamwright_core::learn::losses::{Loss, LossWeights};
use seamwright_core::learn::train::train;
use seamwright_core::learn::training::{Sample, TrainError, TrainInput, TrainOutput, TrainSettings, Unwatched};
use seamwright_core::mesh::normals::{NormalWeight, vertex_normals};
use seamwright_core::mesh::view::MeshView;
use seamwright_core::parts::settings::PartSettings;
use seamwright_core::pipeline::fitting::{FitSummary, Fitting, LearnedMap, MOST_CHARTS, net_of};
use seamwright_core::pipeline::polygons::{Parts, Source, parts_of_polygons};
use seamwright_core::pipeline::{Input, Method, Output, Packing, Settings, UnwrapError, unwrap, unwrap_by};
use seamwright_core::rays::binned::BinnedBuilder;

/// Rays a vertex.
const RAYS: u32 = 64;
/// Search work of tight packing.
const EFFORT: f64 = 0.05;
/// Texels a side at which coverage is measured.
const RESOLUTION: u32 = 128;
/// Every loss has a weight and step 5 looks at the rare ones again, so that every operation of the tape runs.
const WEIGHTS: LossWeights = LossWeights([1.0, 0.01, 0.01, 0.01, 0.005, 0.01, 1e-2, 0.004, 0.01, 0.01]);
/// A training of seconds on a microcontroller. The width is no multiple of any path's tile.
const TRAINING: TrainSettings = TrainSettings {
    widths: Widths { hidden: 21, code: 5 },
    steps: 7,
    batch: 60,
    weights: WEIGHTS,
    ..TrainSettings::PAPER
};

/// A learned map of seconds; steps of both stages.
const FIT: FitSettings = FitSettings { widths: Widths { hidden: 21, code: 5 }, steps: 10, ..FitSettings::DRAFT };

/// A hash of what each stage wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages {
    /// Exposure of each vertex.
    pub exposure: u64,
    /// Part and shape diameter of each face.
    pub labels: u64,
    /// Weights, losses, UVs and seam scores of the training.
    pub weights: u64,
    /// UV of each corner and chart of each face of the exact unwrap, whose borders of parts are cuts.
    pub uvs: u64,
    /// All figures of that atlas.
    pub metrics: u64,
    /// Weights and cuts of a learned map of the mesh without its parts, and UV of each corner.
    pub map: u64,
}

/// Why there are no hashes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failure {
    /// The text is no mesh of triangles.
    Mesh,
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// Parts or the atlas failed.
    Unwrap(UnwrapError),
    /// The training failed.
    Train(TrainError),
    /// The measuring failed.
    Measure(MeasureError),
    /// The lines could not be written.
    Output,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Mesh => f.write_str("the text is no mesh of triangles"),
            Failure::Scratch(e) => e.fmt(f),
            Failure::Unwrap(e) => e.fmt(f),
            Failure::Train(e) => e.fmt(f),
            Failure::Measure(e) => e.fmt(f),
            Failure::Output => f.write_str("the lines could not be written"),
        }
    }
}

impl From<ScratchTooSmall> for Failure {
    fn from(e: ScratchTooSmall) -> Self {
        Failure::Scratch(e)
    }
}

/// Runs every stage on the OBJ in `text`.
pub fn stages(
    text: &str,
    packing: Packing,
    seed: u64,
    memory: &mut [u8],
    path: Path,
    workers: &dyn Workers,
) -> Result<Stages, Failure> {
    let mut scratch = Scratch::new(memory);
    let mesh = read(text, &mut scratch)?;
    let Mesh { positions, faces } = mesh;
    let polygon_start = scratch.take::<u32>(faces.len() + 1)?;
    polygon_start.iter_mut().enumerate().for_each(|(i, start)| *start = 3 * i as u32);
    let corners = faces.as_flattened();
    let input = Input::new(positions, corners, polygon_start);

    let part = scratch.take::<u32>(faces.len())?;
    let diameter = scratch.take::<f32>(faces.len())?;
    let shape = Source::Shape(PartSettings { seed, ..Default::default() });
    let out = Parts { part, diameter };
    let (bvh, frame) = (&BinnedBuilder, scratch.frame());
    let parts = parts_of_polygons(out, &input, shape, bvh, frame, workers, &mut Silent).map_err(Failure::Unwrap)?;
    let labels = Hash::new().u32s([parts as u32]).u32s(part.iter().copied()).f32s(diameter.iter().copied()).end();

    let corner_uv = scratch.take::<DVec2>(corners.len())?;
    let polygon_chart = scratch.take::<u32>(faces.len())?;
    let exposure = scratch.take::<f32>(positions.len())?;
    let settings = Settings { rays: RAYS, effort: EFFORT, packing, seed, ..Settings::default() };
    let input = Input { parts: Some(part), ..input };
    let out = Output { corner_uv, polygon_chart, exposure };
    unwrap(out, &input, &settings, bvh, scratch.frame(), workers, &mut Silent).map_err(Failure::Unwrap)?;
    let uvs = Hash::new().f64s(corner_uv.iter().flat_map(|uv| uv.to_array())).u32s(polygon_chart.iter().copied()).end();

    let map = learned(&Input { parts: None, ..input }, &settings, scratch.frame(), workers)?;
    let weights = training(mesh, exposure, seed, scratch.frame(), path, workers)?;
    let (corner_uv, _) = corner_uv.as_chunks::<3>();
    let judged = UvMesh { positions, triangles: faces, corner_uv };
    let measured = measure(judged, Some(exposure), RESOLUTION, scratch.frame()).map_err(Failure::Measure)?;
    Ok(Stages {
        exposure: Hash::new().f32s(exposure.iter().copied()).end(),
        labels,
        weights,
        uvs,
        metrics: figures::hash(&measured),
        map,
    })
}

/// Learns a map of the charts of `input`; the hash of the map and its UVs.
fn learned(input: &Input, settings: &Settings, mut scratch: Scratch, workers: &dyn Workers) -> Result<u64, Failure> {
    let corners = input.corners.len();
    let corner_uv = scratch.take::<DVec2>(corners)?;
    let polygon_chart = scratch.take::<u32>(corners / 3)?;
    let exposure = scratch.take::<f32>(input.positions.len())?;
    let fit = FitSettings { seed: settings.seed, ..FIT };
    let map = LearnedMap {
        weights: scratch.take(net_of(&fit, MOST_CHARTS).parameter_count())?,
        cut: scratch.take(corners)?,
        corrected: scratch.take(corners)?,
    };
    let curve = &mut [FitSample::default(); FIT.steps];
    let mut fitting = Fitting { settings: fit, map, is_given: false, curve, summary: FitSummary::default() };
    let out = Output { corner_uv, polygon_chart, exposure };
    let method = Method::Neural(&mut fitting);
    unwrap_by(method, out, input, settings, &BinnedBuilder, scratch, workers, &mut Silent).map_err(Failure::Unwrap)?;
    let terms = fitting.curve.iter().flat_map(|sample| sample.terms);
    let values = fitting.map.weights.iter().copied().chain(terms);
    let cuts = fitting.map.cut.iter().map(|cut| u32::from(*cut));
    Ok(Hash::new().f32s(values).u32s(cuts).f64s(corner_uv.iter().flat_map(|uv| uv.to_array())).end())
}

/// Trains a map as published; the hash of all that the training writes.
fn training(
    mesh: Mesh,
    exposure: &[f32],
    seed: u64,
    mut scratch: Scratch,
    path: Path,
    workers: &dyn Workers,
) -> Result<u64, Failure> {
    let n = mesh.positions.len();
    let exact = scratch.take::<DVec3>(n)?;
    vertex_normals(exact, MeshView { positions: mesh.positions, faces: mesh.faces }, NormalWeight::Angle);
    let positions = scratch.take::<[f32; 3]>(n)?;
    let normals = scratch.take::<[f32; 3]>(n)?;
    for v in 0..n {
        positions[v] = mesh.positions[v].as_vec3().to_array();
        normals[v] = exact[v].as_vec3().to_array();
    }
    let faces = mesh.faces.as_flattened();
    let input = TrainInput { positions: positions.as_flattened(), normals: normals.as_flattened(), faces, exposure };
    let q = scratch.take::<f32>(2 * n)?;
    let scores = scratch.take::<f32>(n)?;
    let weights = scratch.take::<f32>(TRAINING.widths.parameter_count())?;
    let curve = &mut [Sample { step: 0, losses: [0.0; Loss::ALL.len()] }; TRAINING.steps];
    let settings = TrainSettings { seed, ..TRAINING };
    let out = TrainOutput { q, scores, weights, curve };
    train(out, input, &settings, path, workers, &mut Unwatched, &mut scratch).map_err(Failure::Train)?;
    let losses = curve.iter().flat_map(|sample| sample.losses);
    let values = weights.iter().chain(q.iter()).chain(scores.iter()).copied();
    Ok(Hash::new().f32s(values).f32s(losses).end())
}
