//! Figures of UV-mapped meshes, as records for `--json` and as a table for people.
//!
//! One file is one [`Record`]: flat, its keys those of the evaluators that it can be compared with, plus our own. JSON has
//! no infinity and no NaN: a figure that is infinite (energies of a collapsed map) or over nothing (exposure of a map
//! without seams) is null; the counts beside it say which.

use crate::figures::agreement::AgreementRecord;
use comfy_table::{CellAlignment, Table, presets};
use glam::{DVec2, DVec3};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::judge::input::{UvMesh, fan};
use seamwright_core::judge::measure::{MeasureError, Metrics, measure_need};
use serde::Serialize;

/// Polygons over positions, as a file has them.
#[derive(Clone, Copy)]
pub struct Polygons<'a> {
    /// Vertex positions.
    pub positions: &'a [DVec3], // (n)
    /// Vertex of each polygon corner.
    pub corners: &'a [u32], // (c)
    /// First corner of each polygon, and the number of corners at the end.
    pub polygon_start: &'a [u32], // (p + 1)
    /// UV of each corner, NaN where it has none; `None` where the file has none at all.
    pub corner_uv: Option<&'a [DVec2]>, // (c)
}

/// How directions were weighed for exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weighting {
    /// Every direction of the hemisphere alike.
    Uniform,
    /// By the cosine with the normal.
    Cosine,
}

/// Exposure of each vertex: 1 open, 0 occluded.
#[derive(Clone, Copy)]
pub struct Exposure<'a> {
    /// One value a vertex.
    pub values: &'a [f32], // (n)
    /// How it was sampled.
    pub weighting: Weighting,
}

/// Figures of one file. Lengths ending in `_norm` are over sqrt(area); `_aw` is weighted by area.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys are explained in docs/FORMATS.md and beside `Metrics`
pub struct Record {
    pub obj: String,
    pub vertices: usize,
    pub faces: usize,
    pub faces_without_vt: usize,
    pub area_3d: f64,
    pub area_frac_without_vt: f64,
    pub uv_bbox: Option<[f64; 4]>,

    pub degenerate_3d_faces: usize,
    pub zero_uv_faces: usize,
    pub collapsed_faces: usize,
    pub conformality: f64,
    pub equiareality: f64,
    pub angle_err_rad: f64,
    pub angle_err_rad_aw: f64,
    pub angle_err_p95: f64,
    pub area_ln: f64,
    pub area_ln_aw: f64,
    pub area_ln_p95: f64,
    pub area_ratio: f64,
    pub area_ratio_aw: f64,
    pub qc_ratio: f64,
    pub qc_ratio_aw: f64,
    pub symmetric_dirichlet: f64,
    pub symmetric_dirichlet_finite: f64,
    pub stretch_l2: f64,
    pub stretch_l2_finite: f64,
    pub stretch_linf: f64,
    pub stretch_linf_finite: f64,
    pub worst_angle: WorstFace,
    pub worst_area_ln: WorstFace,
    pub worst_dirichlet: WorstFace,

    pub charts: usize,
    pub non_disk_charts: usize,
    pub mirrored_charts: usize,
    pub flipped_faces: usize,
    pub flipped_area_frac: f64,

    pub boundary_edges: usize,
    pub nonmanifold_edges: usize,
    pub seam_edges: usize,
    pub seam_vertices: usize,
    pub seam_length: f64,
    pub seam_len_norm: f64,
    #[serde(flatten)]
    pub exposure: Option<ExposureRecord>,

    pub resolution: u32,
    pub overlap_frac: f64,
    pub overlap_max_depth: u32,
    pub utilisation: f64,

    pub grid_bits: i32,
    pub overlapping_faces: usize,
    pub overlapping_charts: usize,
    pub overlap_examples: Vec<[u32; 2]>,
    pub exact_flipped_faces: usize,
    pub exact_zero_faces: usize,

    pub uv_area: f64,
    pub smallest_chart: f64,
    pub largest_chart: f64,
    pub texel_density_min: f64,
    pub texel_density_median: f64,
    pub texel_density_max: f64,
    pub texel_density_variation: f64,

    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<AgreementRecord>,
}

/// The face where a figure is largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstFace {
    /// The figure.
    pub value: f64,
    /// Polygon in the file, from 0; `None` where no face counts.
    pub polygon: Option<u32>,
}

/// What exposure says of the seams.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct ExposureRecord {
    pub exposure: Weighting,
    pub all_ao_mean: f64,
    pub all_ao_len: f64,
    pub seam_ao_mean: f64,
    pub seam_ao_len: f64,
    pub seam_ao_ratio: f64,
    pub visible_seam_len_norm: f64,
}

/// Measures a mesh named `name`; `resolution` as for [`seamwright_core::judge::measure::measure`]. Takes about 260
/// bytes a triangle, and four a texel.
pub fn measure(
    name: &str,
    mesh: Polygons,
    exposure: Option<Exposure>,
    resolution: u32,
) -> Result<Record, MeasureError> {
    let soup = Triangles::of(mesh)?;
    let view = UvMesh { positions: mesh.positions, triangles: &soup.triangles, corner_uv: &soup.corner_uv };
    let mut bytes = vec![0; measure_need(mesh.positions.len(), soup.triangles.len(), resolution)];
    let scratch = Scratch::new(&mut bytes);
    let metrics = seamwright_core::judge::measure::measure(view, exposure.map(|e| e.values), resolution, scratch)?;
    Ok(record(name, &metrics, exposure.map(|e| e.weighting), &soup.polygon))
}

/// A record, or a list of them, as pretty JSON.
pub fn json<T: Serialize + ?Sized>(records: &T) -> String {
    serde_json::to_string_pretty(records).expect("records hold only numbers and strings")
}

/// Records as an aligned table, one row a file and a row of means under several.
pub fn table(records: &[Record]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(COLUMNS.iter().map(|c| c.head));
    table.add_rows(records.iter().map(|r| {
        COLUMNS.iter().map(|c| match c.value {
            Value::Name => r.obj.clone(),
            Value::Count(of) => of(r).to_string(),
            Value::Real(digits, of) => number(of(r), digits),
        })
    }));
    if records.len() > 1 {
        table.add_row(COLUMNS.iter().map(|c| match c.value {
            Value::Name => "mean".to_string(),
            Value::Count(of) => number(mean(records, |r| of(r) as f64), 1),
            Value::Real(digits, of) => number(mean(records, of), digits),
        }));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for column in table.column_iter_mut() {
        column.set_padding((0, 2));
    }
    table.trim_fmt()
}

/// The triangles of polygons, as fans from their first corners.
pub(crate) struct Triangles {
    triangles: Vec<[u32; 3]>,
    corner_uv: Vec<[DVec2; 3]>,
    polygon: Vec<u32>,
}

impl Triangles {
    /// Vertices of the triangles alone. `polygon_start` fits `corners`.
    pub(crate) fn of_corners(corners: &[u32], polygon_start: &[u32]) -> Vec<[u32; 3]> {
        let triangles = polygon_start.windows(2).flat_map(|ends| fan(ends[0], ends[1]));
        triangles.map(|t| t.map(|c| corners[c as usize])).collect()
    }

    fn of(mesh: Polygons) -> Result<Self, MeasureError> {
        let missing = mesh.corner_uv.map_or(mesh.corners.len(), |uv| uv.len());
        let last = mesh.polygon_start.last().map_or(0, |end| *end as usize);
        for given in [missing, last] {
            if given != mesh.corners.len() {
                return Err(MeasureError::BadLength { expected: mesh.corners.len(), given });
            }
        }
        let mut out = Self { triangles: vec![], corner_uv: vec![], polygon: vec![] };
        for (p, ends) in mesh.polygon_start.windows(2).enumerate() {
            for triangle in fan(ends[0], ends[1].min(last as u32)) {
                let at = triangle.map(|c| c as usize);
                out.triangles.push(at.map(|c| mesh.corners[c]));
                out.corner_uv.push(mesh.corner_uv.map_or([DVec2::NAN; 3], |uv| at.map(|c| uv[c])));
                out.polygon.push(p as u32);
            }
        }
        Ok(out)
    }
}

fn record(name: &str, m: &Metrics, weighting: Option<Weighting>, polygon: &[u32]) -> Record {
    let (d, c, s, e, a) = (&m.distortion, &m.charts, &m.seams, &m.exact, &m.atlas);
    let worst = |w: seamwright_core::judge::distortion::Worst| WorstFace {
        value: w.value,
        polygon: polygon.get(w.face as usize).copied(),
    };
    Record {
        obj: name.to_string(),
        vertices: m.vertices,
        faces: m.faces,
        faces_without_vt: m.faces_without_uv,
        area_3d: m.area,
        area_frac_without_vt: m.area_without_uv,
        uv_bbox: m.uv_box.map(|b| [b.low.x, b.low.y, b.high.x, b.high.y]),
        degenerate_3d_faces: d.degenerate_faces,
        zero_uv_faces: d.zero_uv_faces,
        collapsed_faces: d.collapsed_faces,
        conformality: d.conformality(),
        equiareality: d.equiareality(),
        angle_err_rad: d.angle,
        angle_err_rad_aw: d.angle_aw,
        angle_err_p95: d.angle_p95,
        area_ln: d.area_ln,
        area_ln_aw: d.area_ln_aw,
        area_ln_p95: d.area_ln_p95,
        area_ratio: d.area_ratio,
        area_ratio_aw: d.area_ratio_aw,
        qc_ratio: d.qc_ratio,
        qc_ratio_aw: d.qc_ratio_aw,
        symmetric_dirichlet: d.symmetric_dirichlet,
        symmetric_dirichlet_finite: d.symmetric_dirichlet_finite,
        stretch_l2: d.stretch_l2,
        stretch_l2_finite: d.stretch_l2_finite,
        stretch_linf: d.stretch_linf,
        stretch_linf_finite: d.stretch_linf_finite,
        worst_angle: worst(d.worst_angle),
        worst_area_ln: worst(d.worst_area_ln),
        worst_dirichlet: worst(d.worst_dirichlet),
        charts: c.count,
        non_disk_charts: c.non_disks,
        mirrored_charts: c.mirrored,
        flipped_faces: c.flipped_faces,
        flipped_area_frac: c.flipped_area,
        boundary_edges: s.boundary_edges,
        nonmanifold_edges: s.nonmanifold_edges,
        seam_edges: s.edges,
        seam_vertices: s.vertices,
        seam_length: s.length,
        seam_len_norm: s.length_norm,
        exposure: s.exposure.zip(weighting).map(|(x, exposure)| ExposureRecord {
            exposure,
            all_ao_mean: x.all_mean,
            all_ao_len: x.all_length,
            seam_ao_mean: x.seam_mean,
            seam_ao_len: x.seam_length,
            seam_ao_ratio: x.ratio,
            visible_seam_len_norm: x.visible_length_norm,
        }),
        resolution: m.coverage.resolution,
        overlap_frac: m.coverage.overlap_fraction(),
        overlap_max_depth: m.coverage.max_depth,
        utilisation: m.coverage.utilisation(),
        grid_bits: e.grid_bits,
        overlapping_faces: e.overlapping_faces,
        overlapping_charts: e.overlapping_charts,
        overlap_examples: e.examples[..e.examples.len().min(e.overlapping_faces)].to_vec(),
        exact_flipped_faces: e.flipped_faces,
        exact_zero_faces: e.zero_faces,
        uv_area: a.uv_area,
        smallest_chart: a.smallest_chart,
        largest_chart: a.largest_chart,
        texel_density_min: a.density_min,
        texel_density_median: a.density_median,
        texel_density_max: a.density_max,
        texel_density_variation: a.density_variation,
        agreement: None,
    }
}

/// What a cell shows.
#[derive(Clone, Copy)]
enum Value {
    Name,
    Count(fn(&Record) -> usize),
    /// Digits behind the point, and the figure.
    Real(usize, fn(&Record) -> f64),
}

struct Column {
    head: &'static str,
    value: Value,
}

const fn column(head: &'static str, value: Value) -> Column {
    Column { head, value }
}

const COLUMNS: &[Column] = &[
    column("file", Value::Name),
    column("faces", Value::Count(|r| r.faces)),
    column("no uv", Value::Count(|r| r.faces_without_vt)),
    column("charts", Value::Count(|r| r.charts)),
    column("no disk", Value::Count(|r| r.non_disk_charts)),
    column("mirrored", Value::Count(|r| r.mirrored_charts)),
    column("flipped", Value::Count(|r| r.exact_flipped_faces)),
    column("overlapping", Value::Count(|r| r.overlapping_faces)),
    column("conf", Value::Real(3, |r| r.conformality)),
    column("equi", Value::Real(3, |r| r.equiareality)),
    column("sd/4", Value::Real(4, |r| r.symmetric_dirichlet / 4.0)),
    column("stretch", Value::Real(3, |r| r.stretch_l2)),
    column("fill", Value::Real(3, |r| r.utilisation)),
    column("density +-", Value::Real(3, |r| r.texel_density_variation)),
    column("seam", Value::Real(2, |r| r.seam_len_norm)),
    column("visible", Value::Real(2, |r| r.exposure.map_or(f64::NAN, |e| e.visible_seam_len_norm))),
    column("ratio", Value::Real(2, |r| r.exposure.map_or(f64::NAN, |e| e.seam_ao_ratio))),
];

/// A figure with fixed digits; a dash where there is none.
pub(crate) fn number(x: f64, digits: usize) -> String {
    if x.is_nan() { "-".to_string() } else { format!("{x:.digits$}") }
}

/// Mean over the records that have the figure.
fn mean(records: &[Record], of: impl Fn(&Record) -> f64) -> f64 {
    let values: Vec<f64> = records.iter().map(of).filter(|x| !x.is_nan()).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pentagon and a triangle beside it; the triangle has UV where `mapped`.
    fn judge(mapped: bool) -> Result<Record, MeasureError> {
        let uv: Vec<DVec2> =
            [(0., 0.), (2., 0.), (3., 1.), (2., 2.), (0., 2.), (4., 2.)].map(|(x, y)| DVec2::new(x, y) / 4.0).to_vec();
        let positions: Vec<DVec3> = uv.iter().map(|p| p.extend(0.0)).collect();
        let corners = [0, 1, 2, 3, 4, 2, 5, 3];
        let mut corner_uv = corners.map(|v| uv[v as usize]);
        if !mapped {
            corner_uv[5] = DVec2::NAN;
        }
        let exposure = Exposure { values: &[0.5; 6], weighting: Weighting::Cosine };
        let mesh = Polygons {
            positions: &positions,
            corners: &corners,
            polygon_start: &[0, 5, 8],
            corner_uv: Some(&corner_uv),
        };
        measure("pentagon.obj", mesh, Some(exposure), 64)
    }

    #[test]
    fn polygons_are_judged_as_fans_and_named_by_their_place_in_the_file() {
        let r = judge(true).unwrap();
        assert_eq!((r.faces, r.charts, r.faces_without_vt, r.seam_edges), (4, 1, 0, 0));
        assert_eq!(judge(false).unwrap().faces_without_vt, 1);
        assert!(r.worst_angle.polygon.is_some_and(|p| p < 2));
    }

    #[test]
    fn json_has_the_evaluators_keys_and_null_for_what_is_not_there() {
        let value: serde_json::Value = serde_json::from_str(&json(&judge(true).unwrap())).unwrap();
        assert_eq!(value["symmetric_dirichlet"], 4.0);
        assert_eq!(value["exposure"], "cosine");
        assert!(value["seam_ao_len"].is_null() && value["visible_seam_len_norm"] == 0.0);
        let two: serde_json::Value =
            serde_json::from_str(&json(&[judge(true).unwrap(), judge(true).unwrap()])).unwrap();
        assert_eq!(two.as_array().unwrap().len(), 2);
    }

    #[test]
    fn columns_of_the_table_line_up_and_several_files_have_a_mean() {
        let text = table(&[judge(true).unwrap(), judge(false).unwrap()]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines[3].starts_with("mean") && lines[0].contains("visible"));
        let end = |line: &str, word: &str| line.find(word).map(|i| i + word.len());
        assert_eq!(end(lines[0], "sd/4"), end(lines[1], "1.0000"), "{text}");
        assert_eq!(table(&[judge(true).unwrap()]).lines().count(), 2);
    }

    #[test]
    fn lengths_that_do_not_fit_are_an_error() {
        let mesh = Polygons { positions: &[], corners: &[0, 0, 0], polygon_start: &[0, 9], corner_uv: None };
        assert_eq!(measure("x", mesh, None, 0), Err(MeasureError::BadLength { expected: 3, given: 9 }));
    }
}
