//! Part-aware atlases through core: whatever the labels are, no chart crosses a border and every guarantee holds.

use glam::DVec2;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::hierarchy::ObvhsBuilder;
use seamwright::run::threads::Pool;
use seamwright_core::base::progress::Silent;
use seamwright_core::base::random::hash;
use seamwright_core::base::scratch::Scratch;
use seamwright_core::base::workers::{Serial, Workers};
use seamwright_core::judge::input::{UvMesh, fan};
use seamwright_core::judge::measure::{measure, measure_need};
use seamwright_core::parts::settings::PartSettings;
use seamwright_core::pipeline::polygons::{Parts, Source, parts_of_polygons, parts_of_polygons_need};
use seamwright_core::pipeline::{Input, Output, Packing, Settings, unwrap, unwrap_need};
use seamwright_tests::shapes;

/// Charts of polygons and UVs of corners, on the grid, which is the fastest packing.
fn atlas(mesh: &Mesh, parts: &[u32], workers: &dyn Workers) -> (Vec<u32>, Vec<DVec2>) {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    let input = Input { parts: Some(parts), ..Input::new(positions, corners, polygon_start) };
    let settings = Settings { rays: 64, packing: Packing::Grid, ..Settings::default() };
    let mut bytes = vec![0; unwrap_need(&input, &settings, &ObvhsBuilder)];
    let (mut corner_uv, mut polygon_chart) = (vec![DVec2::NAN; corners.len()], vec![0; parts.len()]);
    let mut exposure = vec![0.0; positions.len()];
    let output = Output { corner_uv: &mut corner_uv, polygon_chart: &mut polygon_chart, exposure: &mut exposure };
    let scratch = Scratch::new(&mut bytes);
    let report = unwrap(output, &input, &settings, &ObvhsBuilder, scratch, workers, &mut Silent).expect("an atlas");
    assert_eq!((report.flipped, report.overlapping), (0, 0));
    (polygon_chart, corner_uv)
}

/// Part and diameter of every polygon, by the shape alone.
fn found(mesh: &Mesh, workers: &dyn Workers) -> (Vec<u32>, Vec<f32>) {
    let Mesh { positions, corners, polygon_start, .. } = mesh;
    let input = Input::new(positions, corners, polygon_start);
    let (mut part, mut diameter) = (vec![0; mesh.polygon_count()], vec![0.0; mesh.polygon_count()]);
    let mut bytes = vec![0; parts_of_polygons_need(&input, &ObvhsBuilder)];
    let out = Parts { part: &mut part, diameter: &mut diameter };
    let source = Source::Shape(PartSettings::default());
    let scratch = Scratch::new(&mut bytes);
    let count = parts_of_polygons(out, &input, source, &ObvhsBuilder, scratch, workers, &mut Silent).expect("parts");
    assert!(part.iter().all(|p| (*p as usize) < count));
    (part, diameter)
}

/// No chart has polygons of two parts, charts are disks, and nothing flips or overlaps.
fn holds(mesh: &Mesh, parts: &[u32]) {
    let (chart, uv) = atlas(mesh, parts, &Serial);
    let mut part_of = std::collections::HashMap::new();
    for (chart, part) in chart.iter().zip(parts) {
        assert_eq!(part_of.entry(chart).or_insert(part), &part, "chart {chart} has two parts");
    }
    let corners: Vec<[u32; 3]> = mesh.polygon_start.windows(2).flat_map(|ends| fan(ends[0], ends[1])).collect();
    let triangles: Vec<[u32; 3]> = corners.iter().map(|t| t.map(|c| mesh.corners[c as usize])).collect();
    let corner_uv: Vec<[DVec2; 3]> = corners.iter().map(|t| t.map(|c| uv[c as usize])).collect();
    let mut bytes = vec![0; measure_need(mesh.positions.len(), triangles.len(), 0)];
    let view = UvMesh { positions: &mesh.positions, triangles: &triangles, corner_uv: &corner_uv };
    let m = measure(view, None, 0, Scratch::new(&mut bytes)).expect("indices are right");
    let faults = [m.exact.flipped_faces, m.exact.overlapping_faces, m.charts.closed_or_handled, m.faces_without_uv];
    assert_eq!(faults, [0; 4], "flips, overlaps, charts that no plane holds, triangles without UV");
    assert_eq!(atlas(mesh, parts, &Pool::new(Some(3)).expect("threads")), (chart, uv), "threads change the atlas");
}

#[test]
fn halves_of_a_sphere_keep_their_border_and_their_numbers() {
    let mesh = shapes::sphere();
    let half = |p: usize| u32::from(mesh.corners[mesh.polygon(p)].iter().any(|v| mesh.positions[*v as usize].z > 1e-9));
    let parts: Vec<u32> = (0..mesh.polygon_count()).map(half).collect();
    holds(&mesh, &parts);
    let (chart, _) = atlas(&mesh, &parts, &Serial);
    for part in 0..2 {
        let main = chart.iter().zip(&parts).any(|(c, p)| *c == part && *p == part);
        assert!(main, "the largest chart of part {part} has its number");
    }
}

#[test]
fn random_labels_give_sound_atlases_whatever_the_shape() {
    for (i, mesh) in [shapes::cube(), shapes::sphere(), shapes::torus(), shapes::moebius(), shapes::open_cylinder()]
        .iter()
        .enumerate()
    {
        for labels in [2, 5] {
            let parts: Vec<u32> =
                (0..mesh.polygon_count()).map(|p| (hash(i as u64, labels, p as u64) % labels) as u32).collect();
            holds(mesh, &parts);
        }
    }
}

#[test]
fn parts_of_a_shape_do_not_depend_on_threads() {
    for mesh in [shapes::cube(), shapes::torus(), shapes::two_components(), shapes::open_cylinder()] {
        assert_eq!(found(&mesh, &Serial), found(&mesh, &Pool::new(Some(3)).expect("threads")));
        holds(&mesh, &found(&mesh, &Serial).0);
    }
}
