//! The whole road through core: polygons in, an atlas out, and everything that an atlas is promised to be.
//!
//! Flips, overlaps and charts are judged on the triangles that repair makes of the polygons: a fan over a concave
//! polygon, as a reader without care makes it, is folded in space already.

use glam::DVec3;
use seamwright::formats::loaded::load;
use seamwright::mesh::polygons::Mesh;
use seamwright::run::hierarchy::ObvhsBuilder;
use seamwright::run::threads::Pool;
use seamwright_core::base::progress::Silent;
use seamwright_core::base::scratch::ScratchTooSmall;
use seamwright_core::base::workers::Serial;
use seamwright_core::pipeline::{Charts, Input, Packing, Report, Settings, UnwrapError, unwrap_need};
use seamwright_tests::road::{Atlas, input, judge, run, run_told, unsound};
use seamwright_tests::shapes;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// UVs on a grid of 2^-24 move the mean distortion by about 1e-7.
const BOUND_SLACK: f64 = 1e-6;

/// Fewer rays than the default: the tests are about validity, which does not hang on them.
fn settings() -> Settings {
    Settings { rays: 64, ..Settings::default() }
}

/// What is wrong with an atlas; nothing where all is well. On the grid each chart has a scale of its own, so there the
/// distortion is core's own figure.
fn faults(mesh: &Mesh, atlas: &Atlas, report: &Report, packing: Packing) -> Vec<String> {
    let m = judge(mesh, atlas);
    let mut out = unsound(&m, atlas, report);
    let judged = m.distortion.symmetric_dirichlet / 4.0;
    let distortion = if packing == Packing::Grid { report.distortion } else { judged };
    let any_area = m.distortion.degenerate_faces < m.faces;
    let held = (1.0 - 1e-9..=settings().distortion * (1.0 + BOUND_SLACK)).contains(&distortion);
    // Where no map holds the bound, the report has to say that it is missed.
    let told = report.distortion > settings().distortion && below_the_grid(mesh) > 0.5;
    if any_area && !held && !told {
        out.push(format!("distortion: {distortion}"));
    }
    out
}

/// Share of the triangles' area that no square of 2^24 grid steps can show: where an edge as long as the square leaves
/// less than a step for the height over it. Only what has three corners counts.
fn below_the_grid(mesh: &Mesh) -> f64 {
    let (mut below, mut all) = (0.0, 0.0);
    for polygon in mesh.polygons().filter(|p| p.len() == 3) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[mesh.corners[polygon.start + i] as usize]);
        let doubled = (b - a).cross(c - a).length();
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        all += doubled;
        below += if doubled / (longest * longest) < 1.0 / f64::from(1 << 24) { doubled } else { 0.0 };
    }
    if all > 0.0 { below / all } else { 0.0 }
}

/// All that one mesh is promised.
fn hold(mesh: &Mesh) {
    let settings = settings();
    let (atlas, report) = run(mesh, &settings, &Serial, 0).expect("an atlas");
    assert_eq!(faults(mesh, &atlas, &report, Packing::Tight), Vec::<String>::new());

    // Packing tightly takes most of the time and has tests of its own: threads and scales go through the rest as well.
    let grid = Settings { packing: Packing::Grid, ..settings };
    let (on_grid, _) = run(mesh, &grid, &Serial, 0).expect("an atlas");
    for threads in [1, 2, 7] {
        let pool = Pool::new(Some(threads)).expect("threads");
        assert_eq!(run(mesh, &grid, &pool, 0).expect("an atlas").0, on_grid, "{threads} threads");
    }
    assert_eq!(run(mesh, &settings, &Pool::new(Some(7)).expect("threads"), 0).expect("an atlas").0, atlas, "7 threads");
    for scale in [0.25, 1024.0] {
        let scaled = Mesh { positions: mesh.positions.iter().map(|p| *p * scale).collect(), ..mesh.clone() };
        assert_eq!(run(&scaled, &grid, &Serial, 0).expect("an atlas").0, on_grid, "scaled by {scale}");
    }

    let need = unwrap_need(&input(mesh), &settings, &ObvhsBuilder);
    let refused = run(mesh, &settings, &Serial, -1).map(|_| ());
    assert_eq!(refused, Err(UnwrapError::Scratch(ScratchTooSmall { need, given: need - 1 })));
}

#[test]
fn a_cube_has_a_sound_atlas() {
    hold(&shapes::cube());
}

#[test]
fn a_sphere_has_a_sound_atlas() {
    hold(&shapes::sphere());
}

#[test]
fn a_torus_has_a_sound_atlas() {
    hold(&shapes::torus());
}

#[test]
fn an_open_cylinder_has_a_sound_atlas() {
    hold(&shapes::open_cylinder());
}

#[test]
fn a_moebius_strip_has_a_sound_atlas() {
    hold(&shapes::moebius());
}

#[test]
fn a_klein_bottle_has_a_sound_atlas() {
    hold(&shapes::klein_bottle());
}

#[test]
fn a_book_of_five_pages_has_a_sound_atlas() {
    hold(&shapes::book());
}

#[test]
fn a_polygon_of_many_corners_has_a_sound_atlas() {
    hold(&shapes::disc(64));
}

/// Nodes of 600 neighbours defeat the estimate of a chart's memory: it gets all there is.
#[test]
fn a_cylinder_whose_lids_are_fans_has_a_sound_atlas() {
    let mesh = shapes::cylinder_with_fans(600);
    let grid = Settings { packing: Packing::Grid, ..settings() };
    let (atlas, report) = run(&mesh, &grid, &Serial, 0).expect("an atlas");
    assert_eq!(faults(&mesh, &atlas, &report, Packing::Grid), Vec::<String>::new());
}

#[test]
fn a_floor_whose_holes_meet_in_a_point_has_a_sound_atlas() {
    let mesh = shapes::pits_that_touch();
    hold(&mesh);
    // The whole floor as a chart of its own.
    let is_floor = |p: std::ops::Range<usize>| mesh.corners[p].iter().all(|v| mesh.positions[*v as usize].z == 0.0);
    let parts: Vec<u32> = mesh.polygons().map(|p| if is_floor(p.clone()) { 0 } else { p.start as u32 }).collect();
    let input = Input { parts: Some(&parts), ..input(&mesh) };
    let (atlas, report) =
        run_told(&input, &settings(), &Serial, 0, &mut Silent, &AtomicBool::new(false)).expect("an atlas");
    assert_eq!(faults(&mesh, &atlas, &report, Packing::Tight), Vec::<String>::new());
}

#[test]
fn two_components_have_a_sound_atlas() {
    hold(&shapes::two_components());
}

#[test]
fn quads_with_concave_polygons_have_a_sound_atlas() {
    hold(&shapes::concave_prism());
}

#[test]
fn a_vertex_that_no_face_names_and_a_face_without_area_do_no_harm() {
    let mut mesh = shapes::cube();
    mesh.positions.push(DVec3::NAN);
    mesh.corners.extend([0, 1, 0]);
    mesh.polygon_start.push(mesh.corners.len() as u32);
    hold(&mesh);
}

/// Left out for their time: 100,000 faces, and 150 handles in a soup of 8,000 faces.
const SLOW: &[&str] = &["nefertiti", "mf_520644"];

/// Packed tightly out of the bench, which takes most of the time: limbs, many pieces, sharp edges. The rest goes on the grid.
const TIGHT: &[&str] = &["cow", "suzanne", "fandisk"];

/// Unwraps every OBJ of `folder` that can be loaded, with the packing that `packing` says for its name, and names those
/// that are not sound.
fn sweep(folder: &Path, packing: impl Fn(&str) -> Packing) -> Vec<String> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "obj"));
    files.sort();
    if files.is_empty() {
        println!("skipped: no mesh in {}", folder.display());
    }
    let pool = Pool::new(Some(2)).expect("threads");
    let mut unsound = vec![];
    for path in files {
        let name = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        // What cannot be loaded is the loader's to test.
        let Ok(loaded) = load(&path) else { continue };
        if SLOW.contains(&name.as_str()) || loaded.polygons().is_err() {
            continue;
        }
        let packing = packing(&name);
        let found = match run(loaded.mesh(), &Settings { packing, ..settings() }, &pool, 0) {
            Ok((atlas, report)) => faults(loaded.mesh(), &atlas, &report, packing),
            Err(UnwrapError::NoTriangle) => vec![],
            Err(e) => vec![e.to_string()],
        };
        if !found.is_empty() {
            unsound.push(format!("{name}: {}", found.join(", ")));
        }
    }
    unsound
}

fn beside(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder)
}

#[test]
fn every_fixture_has_a_sound_atlas() {
    assert_eq!(sweep(&beside("fixtures"), |_| Packing::Tight), Vec::<String>::new());
    assert_eq!(sweep(&beside("fixtures/broken"), |_| Packing::Grid), Vec::<String>::new());
}

#[test]
fn animals_and_knots_stay_one_chart_where_that_is_asked_for() {
    for name in ["quadruped", "hand", "knot", "mug"] {
        let loaded = load(&beside("fixtures").join(format!("{name}.obj"))).expect("fixtures can be read");
        let settings = Settings { charts: Charts::One, ..settings() };
        let (atlas, report) =
            run(loaded.mesh(), &settings, &Pool::new(Some(2)).expect("threads"), 0).expect("it has an atlas");
        assert_eq!(report.chart_count, 1, "{name}");
        assert_eq!(faults(loaded.mesh(), &atlas, &report, settings.packing), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn every_mesh_of_the_bench_has_a_sound_atlas() {
    let packing = |name: &str| if TIGHT.contains(&name) { Packing::Tight } else { Packing::Grid };
    assert_eq!(sweep(&beside("../shared/meshes/bench"), packing), Vec::<String>::new());
}

#[test]
fn every_hard_mesh_has_a_sound_atlas() {
    // On the grid to save time.
    assert_eq!(sweep(&beside("../shared/meshes/hard"), |_| Packing::Grid), Vec::<String>::new());
}
