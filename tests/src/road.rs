//! The whole road through core with the command's hierarchy, and the judge over what comes out: for the suites that unwrap.

use core::sync::atomic::AtomicBool;
use glam::DVec2;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::hierarchy::ObvhsBuilder;
use seamwright_core::base::progress::{Progress, Silent};
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::Workers;
use seamwright_core::judge::input::UvMesh;
use seamwright_core::judge::measure::{Metrics, measure, measure_need};
use seamwright_core::mesh::polygons::Polygons;
use seamwright_core::mesh::repair::{Facing, repair, repair_need};
use seamwright_core::pipeline::{Input, Output, Report, Settings, UnwrapError, unwrap, unwrap_need};

/// What core writes.
#[derive(Debug, PartialEq)]
pub struct Atlas {
    /// UV of each corner.
    pub corner_uv: Vec<DVec2>,
    /// Chart of each polygon.
    pub polygon_chart: Vec<u32>,
    /// Exposure of each vertex.
    pub exposure: Vec<f32>,
}

/// A mesh without UVs and parts, as core takes it.
pub fn input(mesh: &Mesh) -> Input<'_> {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    Input::new(positions, corners, polygon_start)
}

/// Unwraps with as many bytes as core asks for and `more`.
pub fn run(
    mesh: &Mesh,
    settings: &Settings,
    workers: &dyn Workers,
    more: isize,
) -> Result<(Atlas, Report), UnwrapError> {
    run_told(&input(mesh), settings, workers, more, &mut Silent, &AtomicBool::new(false))
}

/// As [`run`], of an input that may say more, with somebody who hears of it and may end it.
pub fn run_told(
    input: &Input,
    settings: &Settings,
    workers: &dyn Workers,
    more: isize,
    progress: &mut dyn Progress,
    alarm: &AtomicBool,
) -> Result<(Atlas, Report), UnwrapError> {
    let need = unwrap_need(input, settings, &ObvhsBuilder);
    let mut bytes = vec![0; need.saturating_add_signed(more)];
    let mut atlas = Atlas {
        corner_uv: vec![DVec2::NAN; input.corners.len()],
        polygon_chart: vec![0; input.polygon_start.len() - 1],
        exposure: vec![f32::NAN; input.positions.len()],
    };
    let output = Output {
        corner_uv: &mut atlas.corner_uv,
        polygon_chart: &mut atlas.polygon_chart,
        exposure: &mut atlas.exposure,
    };
    let scratch = Scratch::with_alarm(&mut bytes, alarm);
    let report = unwrap(output, input, settings, &ObvhsBuilder, scratch, workers, progress)?;
    Ok((atlas, report))
}

/// Core's judge on the triangles of the repaired mesh.
pub fn judge(mesh: &Mesh, atlas: &Atlas) -> Metrics {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    let polygons = Polygons { positions, corners, polygon_start, kept_uv: None };
    let mut bytes = vec![0; repair_need(&polygons.counts())];
    let (working, _) = repair(&polygons, Facing::Turned, &mut Scratch::new(&mut bytes)).expect("unwrapped before");
    let source: Vec<[usize; 3]> =
        working.corner_source.chunks_exact(3).map(|c| [0, 1, 2].map(|i| c[i] as usize)).collect();
    let triangles: Vec<[u32; 3]> = source.iter().map(|t| t.map(|c| corners[c])).collect();
    let corner_uv: Vec<[DVec2; 3]> = source.iter().map(|t| t.map(|c| atlas.corner_uv[c])).collect();
    let mut bytes = vec![0; measure_need(positions.len(), triangles.len(), 0)];
    let mesh = UvMesh { positions, triangles: &triangles, corner_uv: &corner_uv };
    measure(mesh, Some(&atlas.exposure), 0, Scratch::new(&mut bytes)).expect("indices are right")
}

/// What makes an atlas invalid, by the judge's figures `m` of it and core's own report; nothing where it is sound.
pub fn unsound(m: &Metrics, atlas: &Atlas, report: &Report) -> Vec<String> {
    let inside = |uv: &DVec2| uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all();
    let counts = [
        ("corners without UV in the unit square", atlas.corner_uv.iter().filter(|uv| !inside(uv)).count()),
        ("values that are no exposure", atlas.exposure.iter().filter(|e| !(0.0..=1.0).contains(*e)).count()),
        ("triangles without UV", m.faces_without_uv),
        ("flipped triangles", m.exact.flipped_faces + m.charts.flipped_faces),
        ("triangles of no UV area", m.exact.zero_faces),
        ("overlapping triangles", m.exact.overlapping_faces),
        ("charts that no plane holds", m.charts.closed_or_handled),
        ("mirrored charts", m.charts.mirrored),
        ("flips by core's own count", report.flipped),
        ("overlaps by core's own count", report.overlapping),
        // At an edge of more than two faces the judge, like others, cannot say which of them hang together.
        (
            "charts miscounted",
            if m.seams.nonmanifold_edges == 0 { report.chart_count.abs_diff(m.charts.count) } else { 0 },
        ),
    ];
    counts.iter().filter(|(_, n)| *n > 0).map(|(what, n)| format!("{what}: {n}")).collect()
}
