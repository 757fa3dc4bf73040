//! Messy meshes as a user unwraps them: what comes out, what is told, and that `measure` says the same.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Runs the command, which has to succeed; what it prints.
fn command(folder: &Path, args: &[&str]) -> Vec<u8> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
    let output = command.args(args).current_dir(folder).output().expect("the command starts");
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Unwraps a fixture with `flags`; the report of the run, and what `measure` says of the file that was written.
fn run(name: &str, flags: &[&str]) -> (Value, Value) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/faults").join(name);
    let command = |args: &[&str]| command(folder.path(), args);
    let path = path.to_str().expect("a path in UTF-8");
    let flags = [&["unwrap", path, "-o", "out.obj", "--json", "report.json", "-q"], flags].concat();
    command(&flags);
    let report = std::fs::read(folder.path().join("report.json")).expect("a report");
    let measured = command(&["measure", "out.obj", "--json", "--exposure", "none"]);
    let [report, measured] = [report, measured].map(|text| serde_json::from_slice::<Value>(&text).expect("JSON"));
    for fault in ["exact_flipped_faces", "flipped_faces", "overlapping_faces", "faces_without_vt"] {
        assert_eq!(measured[fault], 0, "{name}: {fault}");
    }
    assert_eq!(report["result"]["charts"], measured["charts"], "{name}");
    (report, measured)
}

fn warned(report: &Value, words: &str) -> bool {
    report["warnings"].as_array().expect("a list").iter().any(|w| w.as_str().is_some_and(|w| w.contains(words)))
}

/// Charts, triangles turned, polygons dropped and damaged.
fn counts(report: &Value) -> [u64; 4] {
    let repaired = &report["result"]["repaired"];
    [
        &report["result"]["charts"],
        &repaired["flipped_faces"],
        &repaired["dropped_polygons"],
        &repaired["damaged_polygons"],
    ]
    .map(|count| count.as_u64().expect("a count"))
}

#[test]
fn a_face_turned_over_among_others_is_no_chart_and_no_flip() {
    let (report, _) = run("turned_quad.obj", &[]);
    assert_eq!(counts(&report), [1, 2, 0, 0]);
    assert!(warned(&report, "face the other way than their neighbours: 2"), "{report}");
}

#[test]
fn triangles_without_area_cut_nothing() {
    let (report, _) = run("flap.obj", &[]);
    assert_eq!(counts(&report), [1, 0, 1, 0]);
    assert!(warned(&report, "polygons without area"), "{report}");
    let (report, _) = run("filled_junction.obj", &[]);
    assert_eq!(counts(&report), [1, 1, 0, 0]);
}

#[test]
fn a_polygon_that_names_its_corners_again_and_again_is_one_damaged_face() {
    let (report, _) = run("many_names.obj", &[]);
    assert_eq!(counts(&report), [2, 0, 0, 1]);
    assert!(warned(&report, "name the same corners again and again"), "{report}");
}

#[test]
fn a_polygon_with_a_bridged_hole_stays_flat() {
    let (report, _) = run("bridged_hole.obj", &[]);
    assert_eq!(counts(&report), [1, 0, 0, 0]);
    let distortion = report["result"]["distortion"].as_f64().expect("a number");
    assert!(distortion < 1.0 + 1e-6, "{distortion}");
}

#[test]
fn concave_polygons_are_measured_as_they_are_unwrapped() {
    let (report, measured) = run("concave_quads.obj", &[]);
    assert_eq!(counts(&report), [1, 0, 0, 0]);
    assert_eq!(measured["faces"], 4);
}

#[test]
fn seams_that_are_kept_get_no_charts_beside_them() {
    let (report, measured) = run("two_sides.obj", &["--keep-seams"]);
    assert_eq!((counts(&report), &measured["seam_edges"]), ([2, 0, 0, 0], &1.into()));
}

#[test]
fn an_atlas_of_ours_keeps_its_seams_though_its_charts_have_holes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plate = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/solids/plate_x4_y3_b8_r0.2_d0.2_quad.obj");
    let command = |args: &[&str]| command(folder.path(), args);
    command(&["unwrap", plate.to_str().expect("a path in UTF-8"), "-o", "first.obj", "-q"]);
    command(&["unwrap", "first.obj", "-o", "again.obj", "-q", "--keep-seams"]);
    let measured = |name| command(&["measure", name, "--json", "--exposure", "none"]);
    let [first, again] =
        ["first.obj", "again.obj"].map(|name| serde_json::from_slice::<Value>(&measured(name)).expect("JSON"));
    assert!(first["non_disk_charts"].as_u64() > Some(0), "{first}");
    for figure in ["charts", "seam_edges", "seam_length", "non_disk_charts", "overlapping_faces", "flipped_faces"] {
        assert_eq!(first[figure], again[figure], "{figure}");
    }
}

#[test]
fn charts_that_lie_upon_one_another_are_told_apart_by_the_vertices_of_the_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/faults");
    for (name, charts, seams) in [("copies.obj", 2, 6), ("flap_with_uv.obj", 1, 1)] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
        let output = command.args(["measure", name, "--json", "--exposure", "none"]).current_dir(&folder).output();
        let measured: Value = serde_json::from_slice(&output.expect("the command starts").stdout).expect("JSON");
        assert_eq!((&measured["charts"], &measured["seam_edges"]), (&charts.into(), &seams.into()), "{name}");
    }
}
