//! Which charts belong to which part: for the report, and as names of groups.

use crate::formats::groups::Groups;
use crate::run::atlas::Atlas;
use crate::run::parts::MeshParts;
use seamwright_core::mesh::view::NONE;
use serde::Serialize;

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
pub fn tree(parts: &MeshParts, atlas: &Atlas) -> Vec<PartReport> {
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
pub fn groups<'a>(parts: Option<&MeshParts>, atlas: &'a Atlas) -> Groups<'a> {
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
