//! The figures of a UV-mapped mesh, for `--json`.
//!
//! One file is one [`AtlasRecord`]: flat, its keys those of the evaluators that it can be compared with, plus our own. JSON has
//! no infinity and no NaN: a figure that is infinite (energies of a collapsed map) or over nothing (exposure of a map
//! without seams) is null; the counts beside it say which.

use super::agreement::AgreementRecord;
use super::sampled::Weighting;
use serde::Serialize;

/// Figures of one file. Lengths ending in `_norm` are over sqrt(area); `_aw` is weighted by area.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys are explained in docs/FORMATS.md and beside `Metrics`
pub struct AtlasRecord {
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
    pub closed_or_handled_charts: usize,
    pub mirrored_charts: usize,
    pub flipped_faces: usize,
    pub flipped_area_frac: f64,

    pub boundary_edges: usize,
    pub nonmanifold_edges: usize,
    pub seam_edges: usize,
    pub seam_vertices: usize,
    pub seam_length: f64,
    pub seam_len_norm: f64,
    pub seam_flat_share: f64,
    pub seam_sharp_share: f64,
    pub sharp_seam_cover: f64,
    #[serde(flatten)]
    pub exposure: Option<ExposureRecord>,

    pub resolution: u32,
    pub overlap_frac: f64,
    pub overlap_max_depth: u32,
    pub utilisation: f64,

    pub grid_bits: i32,
    pub overlapping_faces: usize,
    pub overlapping_charts: usize,
    pub stacked_charts: usize,
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
    pub noticed_seam_len_norm: f64,
}

/// A record, or a list of them, as pretty JSON.
pub fn json<T: Serialize + ?Sized>(records: &T) -> String {
    serde_json::to_string_pretty(records).expect("records hold only numbers and strings")
}
