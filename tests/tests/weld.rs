//! `--weld` on fixtures that were taken apart: the working copy is that of the whole mesh, and the atlas with it.

use seamwright::mesh::polygons::Mesh;
use seamwright_core::base::progress::Silent;
use seamwright_core::base::workers::Serial;
use seamwright_core::mesh::cracks::Weld;
use seamwright_core::pipeline::{Input, Settings, UnwrapError, unwrap_need};
use seamwright_tests::fixtures::crack::{cracked, patches};
use seamwright_tests::fixtures::{Fixture, nets};
use seamwright_tests::road::{input, run, run_told};
use std::sync::atomic::AtomicBool;

const WIDTH: f64 = 1e-5;

fn settings(weld: Weld) -> Settings {
    Settings { effort: 0.0, rays: 16, weld, ..Settings::default() }
}

fn polygons(mesh: nets::Mesh) -> Mesh {
    let polygon_start = (0..=mesh.faces.len() as u32).map(|f| 3 * f).collect();
    Mesh { positions: mesh.positions, corners: mesh.faces.into_flattened(), polygon_start, ..Mesh::new() }
}

fn fixture(name: &str, faces: usize) -> nets::Mesh {
    Fixture::named(name).expect("a fixture").build(faces).0
}

/// The whole mesh, each vertex where the first of its copies in `apart` is.
fn whole(mesh: &nets::Mesh, apart: &nets::Mesh) -> nets::Mesh {
    let mut first = vec![u32::MAX; mesh.positions.len()];
    for (v, copy) in mesh.faces.as_flattened().iter().zip(apart.faces.as_flattened()) {
        first[*v as usize] = first[*v as usize].min(*copy);
    }
    let at = |(v, copy): (usize, &u32)| apart.positions.get(*copy as usize).copied().unwrap_or(mesh.positions[v]);
    nets::Mesh { positions: first.iter().enumerate().map(at).collect(), faces: mesh.faces.clone() }
}

/// The largest side of the box around a mesh.
fn side(mesh: &Mesh) -> f64 {
    let at = || mesh.positions.iter().copied();
    let (low, high) = (at().reduce(glam::DVec3::min), at().reduce(glam::DVec3::max));
    (high.unwrap_or_default() - low.unwrap_or_default()).max_element()
}

#[test]
fn a_mesh_taken_apart_gives_the_atlas_of_the_whole() {
    for name in ["mug", "gear", "quadruped", "cube", "frame", "sheet"] {
        let mesh = fixture(name, 1500);
        let apart = cracked(&mesh, &patches(&mesh), WIDTH);
        assert!(apart.positions.len() > mesh.positions.len() + 50, "{name}: hardly taken apart");
        let stands_in = polygons(whole(&mesh, &apart));
        let (jittered, before) = (polygons(apart), run(&polygons(mesh), &settings(Weld::Equal), &Serial, 0));
        let mut most = 0;
        for weld in [Weld::Within(1e-4), Weld::Auto] {
            let (atlas, report) = run(&jittered, &settings(weld), &Serial, 0).expect("an atlas");
            assert!(report.repaired.closed_edges > 50, "{name}: {:?}", report.repaired);
            assert!(report.repaired.weld_tolerance < 2e-4, "{name}: {:?}", report.repaired);
            // The whole mesh as exact as the cracks are narrow.
            let tolerance = report.repaired.crack_width * side(&stands_in);
            let known = Input { tolerance, ..input(&stands_in) };
            let expected = run_told(&known, &settings(Weld::Equal), &Serial, 0, &mut Silent, &AtomicBool::new(false))
                .expect("an atlas");
            assert_eq!(report.repaired.components, expected.1.repaired.components, "{name} {weld:?}");
            assert_eq!(report.repaired.boundary_loops, expected.1.repaired.boundary_loops, "{name} {weld:?}");
            assert!(atlas.corner_uv == expected.0.corner_uv, "{name} {weld:?}: other UVs than the whole mesh's");
            assert_eq!(report.chart_count, expected.1.chart_count, "{name} {weld:?}: charts");
            // Where many cuts cost about the same, moving vertices by 1e-5 leads the search elsewhere, cracked or not.
            // A cube's edges all do: one chart more or less is chance there.
            if ["cube", "sheet"].contains(&name) {
                let (charts, before) = (report.chart_count, before.as_ref().expect("an atlas").1.chart_count);
                assert!(
                    charts.abs_diff(before) <= usize::from(name == "cube"),
                    "{name} {weld:?}: {charts} for {before}"
                );
            }
            most = most.max(report.chart_count);
        }
        let (_, apart) = run(&jittered, &settings(Weld::Equal), &Serial, 0).expect("an atlas");
        assert!(apart.chart_count > most && apart.repaired.closed_edges == 0, "{name}");
    }
}

#[test]
fn a_soup_of_triangles_becomes_whole() {
    let mesh = fixture("torus", 1500);
    let each: Vec<u32> = (0..mesh.faces.len() as u32).collect();
    let apart = cracked(&mesh, &each, WIDTH);
    let (_, report) = run(&polygons(apart), &settings(Weld::Auto), &Serial, 0).expect("an atlas");
    let repaired = report.repaired;
    assert_eq!((repaired.components, repaired.boundary_loops, repaired.genus), (1, 0, 1), "{repaired:?}");
    assert_eq!(2 * repaired.closed_edges, repaired.border_edges);
}

#[test]
fn a_whole_mesh_stays_as_it_is() {
    for name in ["mug", "sheet", "hand"] {
        let mesh = polygons(fixture(name, 1500));
        let (atlas, _) = run(&mesh, &settings(Weld::Equal), &Serial, 0).expect("an atlas");
        let (welded, report) = run(&mesh, &settings(Weld::Auto), &Serial, 0).expect("an atlas");
        assert_eq!(report.repaired.closed_edges, 0, "{name}");
        assert!(atlas == welded, "{name}: another atlas");
    }
}

#[test]
fn one_byte_less_is_refused() {
    let mesh = polygons(fixture("sphere", 300));
    let settings = settings(Weld::Auto);
    assert!(unwrap_need(&input(&mesh), &settings, &seamwright::run::hierarchy::ObvhsBuilder) > 0);
    assert!(matches!(run(&mesh, &settings, &Serial, -1), Err(UnwrapError::Scratch(_))));
}
