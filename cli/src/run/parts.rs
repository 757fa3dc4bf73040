//! The parts of a mesh: found by core or read from a file, and what charts belong to them.

use crate::base::failure::Failure;
use crate::formats::groups::Groups;
use crate::formats::labels::of_faces::Labels;
use crate::formats::loaded::Loaded;
use crate::mesh::polygons::Mesh;
use crate::run::atlas::{Atlas, failure, with_enough};
use crate::run::hierarchy::ObvhsBuilder;
use crate::run::progress::Reporter;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::mesh::view::NONE;
use seamwright_core::pipeline::Input;
use seamwright_core::pipeline::polygons::{self, Source, parts_of_polygons, parts_of_polygons_need};
use seamwright_core::segment::parts::Settings;
use serde::Serialize;

/// The parts of a mesh, numbered by size, diameter and place.
pub struct Parts {
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
    settings: Settings,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<Parts, Failure> {
    run(loaded, Source::Shape(settings), workers, progress)
}

/// Takes the parts of `loaded` from `labels`, one a polygon.
pub fn given(
    loaded: &Loaded,
    labels: &Labels,
    workers: &dyn Workers,
    progress: &mut Reporter,
) -> Result<Parts, Failure> {
    let mut parts = run(loaded, Source::Labels(&labels.label), workers, progress)?;
    let mut names = vec![String::new(); parts.count];
    for (part, label) in parts.part.iter().zip(&labels.label) {
        names[*part as usize].clone_from(&labels.names[*label as usize]);
    }
    parts.names = Some(names);
    Ok(parts)
}

fn run(loaded: &Loaded, source: Source, workers: &dyn Workers, progress: &mut Reporter) -> Result<Parts, Failure> {
    let mesh = loaded.polygons()?;
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    let input = Input { positions, corners, polygon_start, kept_uv: None, parts: None };
    let (mut part, mut diameter) = (vec![0; mesh.polygon_count()], vec![0.0; mesh.polygon_count()]);
    let result = with_enough(parts_of_polygons_need(&input, &ObvhsBuilder), |bytes| {
        let out = polygons::Parts { part: &mut part, diameter: &mut diameter };
        parts_of_polygons(out, &input, source, &ObvhsBuilder, Scratch::new(bytes), workers, progress)
    })?;
    let count = result.map_err(|e| failure(loaded, e))?;
    Ok(Parts { part, diameter, count, names: None })
}

/// A part and the charts that cover it, for the report.
#[derive(Debug, Serialize)]
pub struct PartReport {
    /// `part0`, the largest, and so on.
    pub name: String,
    /// What the file of labels calls it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Polygons.
    pub faces: usize,
    /// Mean shape diameter of its polygons, in the mesh's units.
    pub diameter: f64,
    /// Its charts, the largest first.
    pub charts: Vec<ChartReport>,
}

/// A chart, for the report.
#[derive(Debug, Serialize)]
pub struct ChartReport {
    /// `part0_chart0` and so on; `chart0` without parts.
    pub name: String,
    /// Its number in the atlas, and its cell of a grid.
    pub chart: usize,
    /// Polygons.
    pub faces: usize,
}

/// The tree of parts and charts.
pub fn tree(parts: &Parts, atlas: &Atlas) -> Vec<PartReport> {
    let (part_of, faces) = charts(&parts.part, atlas);
    let part = |p: u32| {
        let own = (0..parts.part.len()).filter(|q| parts.part[*q] == p);
        let (count, sum) = own.fold((0, 0.0), |(n, sum), q| (n + 1, sum + f64::from(parts.diameter[q])));
        let charts = (0..part_of.len()).filter(|k| part_of[*k] == p).enumerate();
        PartReport {
            name: format!("part{p}"),
            label: parts.names.as_ref().map(|names| names[p as usize].clone()),
            faces: count,
            diameter: sum / count.max(1) as f64,
            charts: charts
                .map(|(i, k)| ChartReport { name: format!("part{p}_chart{i}"), chart: k, faces: faces[k] })
                .collect(),
        }
    };
    (0..parts.count as u32).map(part).collect()
}

/// A group for each chart, named after its part, where there are parts, and its turn there.
pub fn groups<'a>(parts: Option<&Parts>, atlas: &'a Atlas) -> Groups<'a> {
    let mut names: Vec<String> = (0..atlas.report.chart_count).map(|k| format!("chart{k}")).collect();
    for chart in parts.iter().flat_map(|parts| tree(parts, atlas)).flat_map(|part| part.charts) {
        names[chart.chart] = chart.name;
    }
    Groups { of: &atlas.polygon_chart, names }
}

/// Part and number of polygons of each chart.
fn charts(part: &[u32], atlas: &Atlas) -> (Vec<u32>, Vec<usize>) {
    let count = atlas.report.chart_count;
    let (mut part_of, mut faces) = (vec![NONE; count], vec![0; count]);
    for (chart, part) in atlas.polygon_chart.iter().zip(part).filter(|(chart, _)| **chart != NONE) {
        part_of[*chart as usize] = *part;
        faces[*chart as usize] += 1;
    }
    (part_of, faces)
}
