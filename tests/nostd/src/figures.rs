//! The hash of all figures of an atlas: counts and numbers in the order of their definition.
//!
//! Each struct is taken apart to its last field, so that a new figure has to take its place here.

use crate::hash::Hash;
use seamwright_core::judge::atlas::Atlas;
use seamwright_core::judge::charts::ChartFigures;
use seamwright_core::judge::coverage::Coverage;
use seamwright_core::judge::distortion::{Distortion, Worst};
use seamwright_core::judge::input::UvBox;
use seamwright_core::judge::measure::{Exact, Metrics};
use seamwright_core::judge::seams::{SeamExposure, Seams};
use seamwright_core::judge::stacks::Stacked;

/// The hash of `metrics`.
#[rustfmt::skip]
pub fn hash(metrics: &Metrics) -> u64 {
    let Metrics {
        vertices, faces, faces_without_uv, area, area_without_uv, uv_box, distortion, charts, seams, coverage, exact,
        stacked: Stacked { charts: stacked_charts, faces: stacked_faces }, atlas,
    } = *metrics;
    let hash = Hash::new().sizes([vertices, faces, faces_without_uv]).numbers([area, area_without_uv]);
    let hash = uv_box.into_iter().fold(hash, |hash, UvBox { low, high }| {
        hash.numbers([low.x, low.y, high.x, high.y])
    });
    let hash = of_distortion(hash, distortion);
    let ChartFigures { count, non_disks, closed_or_handled, mirrored, flipped_faces, flipped_area } = charts;
    let hash = hash.sizes([count, non_disks, closed_or_handled, mirrored, flipped_faces]).numbers([flipped_area]);
    let hash = of_seams(hash, seams);
    let Coverage { resolution, covered, overlapped, max_depth } = coverage;
    let hash = hash.u64s([resolution.into(), covered, overlapped, max_depth.into()]);
    let Exact { grid_bits, overlapping_faces, overlapping_charts, examples, flipped_faces, zero_faces } = exact;
    let hash = hash
        .u32s([grid_bits as u32])
        .sizes([overlapping_faces, overlapping_charts, flipped_faces, zero_faces])
        .u32s(examples.into_iter().flatten());
    // A mesh without stacks has the hash that it had before they were counted.
    let hash = if stacked_charts > 0 { hash.sizes([stacked_charts, stacked_faces]) } else { hash };
    let Atlas {
        uv_area, smallest_chart, largest_chart, density_min, density_median, density_max, density_variation,
    } = atlas;
    hash.numbers([uv_area, smallest_chart, largest_chart])
        .numbers([density_min, density_median, density_max, density_variation])
        .end()
}

#[rustfmt::skip]
fn of_distortion(hash: Hash, distortion: Distortion) -> Hash {
    let Distortion {
        degenerate_faces, zero_uv_faces, collapsed_faces, angle, angle_aw, angle_p95, area_ln, area_ln_aw, area_ln_p95,
        area_ratio, area_ratio_aw, qc_ratio, qc_ratio_aw, symmetric_dirichlet, symmetric_dirichlet_finite, stretch_l2,
        stretch_l2_finite, stretch_linf, stretch_linf_finite, worst_angle, worst_area_ln, worst_dirichlet,
    } = distortion;
    let hash = hash
        .sizes([degenerate_faces, zero_uv_faces, collapsed_faces])
        .numbers([angle, angle_aw, angle_p95, area_ln, area_ln_aw, area_ln_p95, area_ratio, area_ratio_aw])
        .numbers([qc_ratio, qc_ratio_aw, symmetric_dirichlet, symmetric_dirichlet_finite])
        .numbers([stretch_l2, stretch_l2_finite, stretch_linf, stretch_linf_finite]);
    [worst_angle, worst_area_ln, worst_dirichlet]
        .into_iter()
        .fold(hash, |hash, Worst { value, face }| hash.numbers([value]).u32s([face]))
}

#[rustfmt::skip]
fn of_seams(hash: Hash, seams: Seams) -> Hash {
    let Seams {
        boundary_edges, nonmanifold_edges, edges, vertices, length, length_norm, flat_share, sharp_share, sharp_cover,
        exposure,
    } = seams;
    let hash = hash
        .sizes([boundary_edges, nonmanifold_edges, edges, vertices])
        .numbers([length, length_norm, flat_share, sharp_share, sharp_cover]);
    exposure.into_iter().fold(hash, |hash, exposure| {
        let SeamExposure {
            all_mean, all_length, seam_mean, seam_length, ratio, visible_length_norm, noticed_length_norm,
        } = exposure;
        hash.numbers([all_mean, all_length, seam_mean, seam_length, ratio, visible_length_norm, noticed_length_norm])
    })
}
