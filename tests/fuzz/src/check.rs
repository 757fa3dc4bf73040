//! What must hold of every atlas: on the grid, in the unit square, and valid by core's judge on the repaired mesh.

use crate::case::Case;
use glam::DVec2;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::measure::{Metrics, measure, measure_need};
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::mesh::polygons::Polygons;
use seamwright_core::mesh::repair::{Facing, repair_welding, repair_welding_need};
use seamwright_core::pipeline::Report;

/// Share of the mean area below which a face has none to speak of, and may have turned over on the grid.
const LEAST_AREA: f64 = 1e-9;

/// An atlas of a case.
pub struct Made {
    pub corner_uv: Vec<DVec2>,
    pub polygon_chart: Vec<u32>,
    pub exposure: Vec<f32>,
}

impl Made {
    /// Room for the atlas of `case`, full of what must not be left there.
    pub fn room(case: &Case) -> Self {
        Self {
            corner_uv: vec![DVec2::NAN; case.corners.len()],
            polygon_chart: vec![0x7777_7777; case.polygon_start.len().saturating_sub(1)],
            exposure: vec![f32::NAN; case.positions.len()],
        }
    }

    /// All of it as bits.
    pub fn bits(&self) -> (Vec<[u64; 2]>, Vec<u32>, Vec<u32>) {
        let uv = self.corner_uv.iter().map(|uv| uv.to_array().map(f64::to_bits)).collect();
        (uv, self.polygon_chart.clone(), self.exposure.iter().map(|e| e.to_bits()).collect())
    }
}

/// Stops the run where the atlas is not valid.
pub fn valid(case: &Case, made: &Made, report: &Report, weld: Weld) {
    let grid = f64::from(1 << 24);
    let is_placed = |x: f64| (0.0..=1.0).contains(&x) && (x * grid).fract() == 0.0;
    assert!(made.corner_uv.iter().all(|uv| is_placed(uv.x) && is_placed(uv.y)), "a UV beside the grid or the square");
    assert!(made.exposure.iter().all(|e| (0.0..=1.0).contains(e)), "exposure beyond [0, 1]");
    let is_chart = |chart: &u32| *chart == u32::MAX || (*chart as usize) < report.chart_count;
    assert!(made.polygon_chart.iter().all(is_chart), "a chart that is none");
    assert_eq!(report.overlapping, 0, "overlaps by the report");
    assert!(report.distortion >= 1.0 - 1e-9 || report.distortion.is_nan(), "distortion {}", report.distortion);
    judged(case, made, weld);
    judged_whole(case, made);
}

/// Flips, overlaps and disks by core's judge, of the repaired mesh with the atlas on it.
fn judged(case: &Case, made: &Made, weld: Weld) {
    let Case { positions, corners, polygon_start, kept_uv, .. } = case;
    let kept_uv = kept_uv.as_deref();
    let polygons = Polygons { positions, corners, polygon_start, kept_uv };
    let mut bytes = vec![0; repair_welding_need(&polygons.counts(), weld)];
    let mut scratch = Scratch::new(&mut bytes);
    let (working, repaired) =
        repair_welding(&polygons, Facing::Turned, weld, &mut scratch).expect("it was repaired before");
    let uv: Vec<DVec2> = working.corner_source.iter().map(|c| made.corner_uv[*c as usize]).collect();
    let mesh = UvMesh { positions: working.positions, triangles: working.faces, corner_uv: uv.as_chunks::<3>().0 };
    let area = |f: usize| {
        let [a, b, c] = mesh.points(f);
        (b - a).cross(c - a).length()
    };
    let least = LEAST_AREA * (0..working.faces.len()).map(area).sum::<f64>() / working.faces.len() as f64;
    for f in 0..working.faces.len() {
        let [p, q, r] = mesh.corner_uv[f];
        assert!(area(f) <= least || (q - p).perp_dot(r - p) > 0.0, "face {f} is turned over");
    }
    let found = figures(mesh);
    assert_eq!(found.faces_without_uv, 0, "faces without UV");
    assert_eq!(found.exact.overlapping_faces, 0, "overlaps by the judge of\n{}", case.obj());
    // The judge goes by place and joins faces at an edge two by two: where repair has split something, its charts are not
    // ours, and where faces have no area to speak of, vertices may fall together on the grid.
    let is_plain = repaired.split_edges + repaired.split_vertices == 0;
    if is_plain && (0..working.faces.len()).all(|f| area(f) > least) {
        assert_eq!(found.charts.closed_or_handled, 0, "charts that no plane holds of\n{}", case.obj());
    }
}

/// Overlaps by core's judge of the triangles of the mesh as it came, those included that repair drops.
fn judged_whole(case: &Case, made: &Made) {
    let ends = case.polygon_start.windows(2).map(|ends| ends[0] as usize..ends[1] as usize);
    let (mut triangles, mut uv) = (vec![], vec![]);
    for at in ends.filter(|polygon| polygon.len() == 3) {
        triangles.push([0, 1, 2].map(|i| case.corners[at.start + i]));
        uv.push([0, 1, 2].map(|i| made.corner_uv[at.start + i]));
    }
    let found = figures(UvMesh { positions: &case.positions, triangles: &triangles, corner_uv: &uv });
    assert_eq!(found.exact.overlapping_faces, 0, "overlaps as it came of\n{}", case.obj());
}

fn figures(mesh: UvMesh) -> Metrics {
    let mut bytes = vec![0; measure_need(mesh.positions.len(), mesh.triangles.len(), 0)];
    measure(mesh, None, 0, Scratch::new(&mut bytes)).expect("the mesh is whole and the memory enough")
}
