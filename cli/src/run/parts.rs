//! The parts of a mesh, found by core or given by labels.

use super::errors::refusal;
use super::hierarchy::ObvhsBuilder;
use super::memory::with_enough;
use super::progress::Reporter;
use super::stop::alarm;
use crate::base::failure::Failure;
use crate::formats::labels::of_faces::Labels;
use crate::formats::loaded::Loaded;
use crate::mesh::polygons::Mesh;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::parts::settings::PartSettings;
use seamwright_core::pipeline::Input;
use seamwright_core::pipeline::polygons::{self, Source, parts_of_polygons, parts_of_polygons_need};

/// The parts of a mesh, numbered by size, diameter and place.
pub struct MeshParts {
    /// Part of each polygon.
    pub part: Vec<u32>, // (p)
    /// Shape diameter of each polygon, in the mesh's units; 0 where there is none.
    pub diameter: Vec<f32>, // (p)
    /// How many parts there are.
    pub count: usize,
    /// What the file of labels calls each part, where they came from one.
    pub names: Option<Vec<String>>,
}

/// Finds the parts of `loaded` by its shape.
pub fn find(
    loaded: &Loaded,
    settings: PartSettings,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<MeshParts, Failure> {
    run(loaded, Source::Shape(settings), workers, progress)
}

/// Takes the parts of `loaded` from `labels`, one a polygon.
pub fn given(
    loaded: &Loaded,
    labels: &Labels,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<MeshParts, Failure> {
    let mut parts = run(loaded, Source::Labels(&labels.label), workers, progress)?;
    let mut names = vec![String::new(); parts.count];
    for (part, label) in parts.part.iter().zip(&labels.label) {
        names[*part as usize].clone_from(&labels.names[*label as usize]);
    }
    parts.names = Some(names);
    Ok(parts)
}

fn run(loaded: &Loaded, source: Source, workers: &dyn Workers, progress: &mut Reporter) -> Result<MeshParts, Failure> {
    let mesh = loaded.polygons()?;
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    let input = Input::new(positions, corners, polygon_start);
    let (mut part, mut diameter) = (vec![0; mesh.polygon_count()], vec![0.0; mesh.polygon_count()]);
    let result = with_enough(parts_of_polygons_need(&input, &ObvhsBuilder), |bytes| {
        let out = polygons::Parts { part: &mut part, diameter: &mut diameter };
        parts_of_polygons(out, &input, source, &ObvhsBuilder, Scratch::with_alarm(bytes, alarm()), workers, progress)
    })?;
    let count = result.map_err(|e| refusal(loaded, e))?;
    Ok(MeshParts { part, diameter, count, names: None })
}
