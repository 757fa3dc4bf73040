//! How far charts or labels agree with reference partitions, as records for `--json` and as a table for people.
//!
//! Faces are the file's polygons; cuts are looked at on the fans of their triangles. Several references are averaged, as the
//! segmentation benchmark does with its humans: each figure over the references that have it.

use super::cells::{align, number};
use crate::formats::labels::of_faces::Labels;
use crate::mesh::polygons::Mesh;
use crate::mesh::triangles::of_mesh;
use comfy_table::{Table, presets};
use glam::DVec2;
use seamwright_core::base::real;
use seamwright_core::base::scratch::{Scratch, ScratchTooSmall};
use seamwright_core::judge::agreement::{agreement, agreement_need};
use seamwright_core::judge::cut_discrepancy::{FileMesh, cut_discrepancy, cut_discrepancy_need};
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::wedges::{uv_topology, uv_topology_need};
use seamwright_core::mesh::view::NONE;
use serde::Serialize;

/// Agreement with all references of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgreementRecord {
    /// `charts`, or the file of labels that was compared.
    pub compared: String,
    /// Its charts or labels.
    pub labels: usize,
    /// Means over the references.
    pub mean: AgreementFigures,
    /// Against each reference.
    pub references: Vec<ReferenceRecord>,
}

/// Agreement with one reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceRecord {
    /// The file.
    pub reference: String,
    /// Its labels.
    pub labels: usize,
    /// Polygons that were compared.
    pub faces: usize,
    /// Polygons without a chart.
    pub left_out: usize,
    /// How they compare.
    #[serde(flatten)]
    pub figures: AgreementFigures,
}

/// The figures; docs/FORMATS.md and core say what each is. Not finite: null.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the keys are explained in docs/FORMATS.md and in core's `Agreement`")]
pub struct AgreementFigures {
    pub hamming: f64,
    pub hamming_aw: f64,
    pub hamming_directional_aw: f64,
    pub missing_aw: f64,
    pub false_alarm_aw: f64,
    pub rand_index: f64,
    pub rand_index_aw: f64,
    pub adjusted_rand_index: f64,
    pub cut_discrepancy: f64,
}

/// Picks one of the figures.
type Pick = fn(&AgreementFigures) -> f64;

/// Heads of the table and their figures.
const COLUMNS: &[(&str, Pick)] = &[
    ("hamming", |f| f.hamming),
    ("by area", |f| f.hamming_aw),
    ("directional", |f| f.hamming_directional_aw),
    ("rand", |f| f.rand_index),
    ("by area", |f| f.rand_index_aw),
    ("adjusted", |f| f.adjusted_rand_index),
    ("cut disc", |f| f.cut_discrepancy),
];

/// Compares `labels`, named `compared`, with `references`; [`NONE`] leaves a polygon out. One label of each a polygon.
pub fn compare(
    compared: &str,
    labels: &[u32],
    references: &[(String, Labels)],
    mesh: &Mesh,
) -> Result<AgreementRecord, ScratchTooSmall> {
    let triangles: Vec<(usize, [u32; 3])> =
        of_mesh(mesh).into_iter().map(|(p, t)| (p, t.map(|c| mesh.corners[c as usize]))).collect();
    let mut area = vec![0.0; mesh.polygon_count()];
    for (p, t) in &triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a);
        area[*p] += 0.5 * real::sqrt(normal.dot(normal));
    }
    let faces: Vec<[u32; 3]> = triangles.iter().map(|(_, t)| *t).collect();
    let of_triangles = |labels: &[u32]| triangles.iter().map(|(p, _)| labels[*p]).collect::<Vec<_>>();
    let ours = of_triangles(labels);
    let need = agreement_need(labels.len()).max(cut_discrepancy_need(mesh.positions.len(), faces.len()));
    let mut bytes = vec![0; need];
    let mut compare = |(name, reference): &(String, Labels)| {
        let a = agreement(labels, &reference.label, &area, Scratch::new(&mut bytes))?;
        let surface = FileMesh { positions: &mesh.positions, triangles: &faces };
        let theirs = of_triangles(&reference.label);
        let cuts = cut_discrepancy(surface, &ours, &theirs, Scratch::new(&mut bytes))?;
        let figures = AgreementFigures {
            hamming: a.hamming,
            hamming_aw: a.hamming_aw,
            hamming_directional_aw: a.directional_hamming_aw(),
            missing_aw: a.missing_aw,
            false_alarm_aw: a.false_alarm_aw,
            rand_index: a.rand,
            rand_index_aw: a.rand_aw,
            adjusted_rand_index: a.adjusted_rand,
            cut_discrepancy: cuts,
        };
        Ok(ReferenceRecord {
            reference: name.clone(),
            labels: a.labels[1],
            faces: a.faces,
            left_out: a.left_out,
            figures,
        })
    };
    let references = references.iter().map(&mut compare).collect::<Result<Vec<_>, _>>()?;
    let mut known: Vec<u32> = labels.iter().copied().filter(|l| *l != NONE).collect();
    known.sort_unstable();
    known.dedup();
    Ok(AgreementRecord { compared: compared.to_string(), labels: known.len(), mean: mean(&references), references })
}

/// Chart of each polygon of a UV-mapped mesh, as `measure` counts charts; [`NONE`] without UV.
pub fn charts(mesh: &Mesh, corner_uv: &[DVec2]) -> Result<Vec<u32>, ScratchTooSmall> {
    let found = of_mesh(mesh);
    let triangles: Vec<[u32; 3]> = found.iter().map(|(_, t)| t.map(|c| mesh.corners[c as usize])).collect();
    let uv: Vec<[DVec2; 3]> = found.iter().map(|(_, t)| t.map(|c| corner_uv[c as usize])).collect();
    let mut bytes = vec![0; uv_topology_need(mesh.positions.len(), triangles.len())];
    let view = UvMesh { positions: &mesh.positions, triangles: &triangles, corner_uv: &uv };
    let topology = uv_topology(view, &mut Scratch::new(&mut bytes))?;
    let mut chart = vec![NONE; mesh.polygon_count()];
    for ((p, _), k) in found.into_iter().zip(topology.chart) {
        if chart[p] == NONE {
            chart[p] = *k;
        }
    }
    Ok(chart)
}

fn mean(references: &[ReferenceRecord]) -> AgreementFigures {
    let of = |figure: Pick| {
        let values: Vec<f64> = references.iter().map(|r| figure(&r.figures)).filter(|x| !x.is_nan()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    AgreementFigures {
        hamming: of(|f| f.hamming),
        hamming_aw: of(|f| f.hamming_aw),
        hamming_directional_aw: of(|f| f.hamming_directional_aw),
        missing_aw: of(|f| f.missing_aw),
        false_alarm_aw: of(|f| f.false_alarm_aw),
        rand_index: of(|f| f.rand_index),
        rand_index_aw: of(|f| f.rand_index_aw),
        adjusted_rand_index: of(|f| f.adjusted_rand_index),
        cut_discrepancy: of(|f| f.cut_discrepancy),
    }
}

/// An aligned table: a row a reference, and one of means under several.
pub fn table(record: &AgreementRecord) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let head = [format!("{} ({}) against", record.compared, record.labels), "labels".into()];
    table.set_header(head.into_iter().chain(COLUMNS.iter().map(|c| c.0.to_string())));
    let row = |name: &str, labels: String, figures: &AgreementFigures| {
        let figures: Vec<String> = COLUMNS.iter().map(|(_, of)| number(of(figures), 3)).collect();
        [vec![name.to_string(), labels], figures].concat()
    };
    table.add_rows(record.references.iter().map(|r| row(&r.reference, r.labels.to_string(), &r.figures)));
    if record.references.len() > 1 {
        let labels = record.references.iter().map(|r| r.labels as f64).sum::<f64>() / record.references.len() as f64;
        table.add_row(row("mean", number(labels, 1), &record.mean));
    }
    align(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Two quads and a triangle in a row; the last one has no UV, the others are a chart each.
    fn row() -> (Mesh, Vec<DVec2>) {
        let positions: Vec<DVec3> = (0..8).map(|i| DVec3::new((i / 2) as f64, (i % 2) as f64, 0.0)).collect();
        let mesh = Mesh {
            positions,
            corners: vec![0, 2, 3, 1, 2, 4, 5, 3, 4, 6, 5],
            polygon_start: vec![0, 4, 8, 11],
            ..Mesh::default()
        };
        let uv = |c: usize| match c {
            0..4 => mesh.positions[mesh.corners[c] as usize].truncate() / 8.0,
            4..8 => mesh.positions[mesh.corners[c] as usize].truncate() / 8.0 + 0.3,
            _ => DVec2::NAN,
        };
        let uv = (0..11).map(uv).collect();
        (mesh, uv)
    }

    #[test]
    fn charts_are_those_of_polygons_and_faces_without_uv_have_none() {
        let (mesh, uv) = row();
        assert_eq!(charts(&mesh, &uv), Ok(vec![0, 1, NONE]));
    }

    #[test]
    fn references_are_averaged_and_those_without_a_figure_left_out_of_its_mean() {
        let (mesh, uv) = row();
        let labels = |label: [u32; 3]| Labels { label: label.to_vec(), names: vec!["a".into(), "b".into()] };
        let references = [("same".to_string(), labels([1, 0, 0])), ("one".to_string(), labels([0, 0, 0]))];
        let record = compare("charts", &charts(&mesh, &uv).unwrap(), &references, &mesh).unwrap();
        assert_eq!((record.labels, record.references[0].faces, record.references[0].left_out), (2, 2, 1));
        assert_eq!((record.references[0].figures.hamming, record.references[1].figures.hamming), (0.0, 0.5));
        assert_eq!((record.mean.hamming, record.mean.rand_index), (0.25, 0.5));
        assert_eq!((record.references[0].figures.cut_discrepancy, record.mean.cut_discrepancy), (0.0, 0.0));
        assert!(record.references[1].figures.cut_discrepancy.is_nan());
        let text = table(&record);
        assert!(text.contains("charts (2) against") && text.contains("mean") && text.contains("0.250"), "{text}");
    }
}
