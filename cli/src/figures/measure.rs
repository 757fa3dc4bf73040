//! Measures a UV-mapped mesh, whatever tool made it, by core's judge.

use super::record::{AtlasRecord, ExposureRecord, WorstFace};
use super::sampled::{SampledExposure, Weighting};
use crate::mesh::triangles::triangles;
use crate::mesh::view::PolygonView;
use glam::DVec2;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::measure::{MeasureError, Metrics, measure_need};

/// Measures a mesh named `name`; `resolution` as for [`seamwright_core::judge::measure::measure`]. Takes about 300
/// bytes a triangle, and four a texel.
pub fn measure(
    name: &str,
    mesh: PolygonView,
    exposure: Option<SampledExposure>,
    resolution: u32,
) -> Result<AtlasRecord, MeasureError> {
    let soup = Triangles::of(mesh)?;
    let view = UvMesh { positions: mesh.positions, triangles: &soup.triangles, corner_uv: &soup.corner_uv };
    let mut bytes = vec![0; measure_need(mesh.positions.len(), soup.triangles.len(), resolution)];
    let scratch = Scratch::new(&mut bytes);
    let metrics = seamwright_core::judge::measure::measure(view, exposure.map(|e| e.values), resolution, scratch)?;
    Ok(record(name, &metrics, exposure.map(|e| e.weighting), &soup.polygon))
}

/// The triangles of polygons.
struct Triangles {
    triangles: Vec<[u32; 3]>,
    corner_uv: Vec<[DVec2; 3]>,
    polygon: Vec<u32>,
}

impl Triangles {
    fn of(mesh: PolygonView) -> Result<Self, MeasureError> {
        let missing = mesh.corner_uv.map_or(mesh.corners.len(), |uv| uv.len());
        let last = mesh.polygon_start.last().map_or(0, |end| *end as usize);
        for given in [missing, last] {
            if given != mesh.corners.len() {
                return Err(MeasureError::BadLength { expected: mesh.corners.len(), given });
            }
        }
        let mut out = Self { triangles: vec![], corner_uv: vec![], polygon: vec![] };
        for (p, triangle) in triangles(mesh) {
            let at = triangle.map(|c| c as usize);
            out.triangles.push(at.map(|c| mesh.corners[c]));
            out.corner_uv.push(mesh.corner_uv.map_or([DVec2::NAN; 3], |uv| at.map(|c| uv[c])));
            out.polygon.push(p as u32);
        }
        Ok(out)
    }
}

fn record(name: &str, m: &Metrics, weighting: Option<Weighting>, polygon: &[u32]) -> AtlasRecord {
    let (d, c, s, e, a) = (&m.distortion, &m.charts, &m.seams, &m.exact, &m.atlas);
    let worst = |w: seamwright_core::judge::distortion::Worst| WorstFace {
        value: w.value,
        polygon: polygon.get(w.face as usize).copied(),
    };
    AtlasRecord {
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
        closed_or_handled_charts: c.closed_or_handled,
        mirrored_charts: c.mirrored,
        flipped_faces: c.flipped_faces,
        flipped_area_frac: c.flipped_area,
        boundary_edges: s.boundary_edges,
        nonmanifold_edges: s.nonmanifold_edges,
        seam_edges: s.edges,
        seam_vertices: s.vertices,
        seam_length: s.length,
        seam_len_norm: s.length_norm,
        seam_flat_share: s.flat_share,
        seam_sharp_share: s.sharp_share,
        sharp_seam_cover: s.sharp_cover,
        exposure: s.exposure.zip(weighting).map(|(x, exposure)| ExposureRecord {
            exposure,
            all_ao_mean: x.all_mean,
            all_ao_len: x.all_length,
            seam_ao_mean: x.seam_mean,
            seam_ao_len: x.seam_length,
            seam_ao_ratio: x.ratio,
            visible_seam_len_norm: x.visible_length_norm,
            noticed_seam_len_norm: x.noticed_length_norm,
        }),
        resolution: m.coverage.resolution,
        overlap_frac: m.coverage.overlap_fraction(),
        overlap_max_depth: m.coverage.max_depth,
        utilisation: m.coverage.utilisation(),
        grid_bits: e.grid_bits,
        overlapping_faces: e.overlapping_faces,
        overlapping_charts: e.overlapping_charts,
        stacked_charts: m.stacked.charts,
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

#[cfg(test)]
pub(super) mod tests {
    use super::super::record::json;
    use super::*;
    use glam::DVec3;

    /// A pentagon and a triangle beside it; the triangle has UV where `mapped`.
    pub fn judge(mapped: bool) -> Result<AtlasRecord, MeasureError> {
        let uv: Vec<DVec2> =
            [(0., 0.), (2., 0.), (3., 1.), (2., 2.), (0., 2.), (4., 2.)].map(|(x, y)| DVec2::new(x, y) / 4.0).to_vec();
        let positions: Vec<DVec3> = uv.iter().map(|p| p.extend(0.0)).collect();
        let corners = [0, 1, 2, 3, 4, 2, 5, 3];
        let mut corner_uv = corners.map(|v| uv[v as usize]);
        if !mapped {
            corner_uv[5] = DVec2::NAN;
        }
        let exposure = SampledExposure { values: &[0.5; 6], weighting: Weighting::Cosine };
        let mesh = PolygonView {
            positions: &positions,
            corners: &corners,
            polygon_start: &[0, 5, 8],
            corner_uv: Some(&corner_uv),
        };
        measure("pentagon.obj", mesh, Some(exposure), 64)
    }

    #[test]
    fn polygons_are_judged_by_their_triangles_and_named_by_their_place_in_the_file() {
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
        assert!(value["sharp_seam_cover"].is_null() && value["noticed_seam_len_norm"] == 0.0);
        assert_eq!((&value["seam_flat_share"], &value["closed_or_handled_charts"]), (&0.0.into(), &0.into()));
        let two: serde_json::Value =
            serde_json::from_str(&json(&[judge(true).unwrap(), judge(true).unwrap()])).unwrap();
        assert_eq!(two.as_array().unwrap().len(), 2);
    }

    #[test]
    fn lengths_that_do_not_fit_are_an_error() {
        let mesh = PolygonView { positions: &[], corners: &[0, 0, 0], polygon_start: &[0, 9], corner_uv: None };
        assert_eq!(measure("x", mesh, None, 0), Err(MeasureError::BadLength { expected: 3, given: 9 }));
    }
}
