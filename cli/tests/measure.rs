//! `seamwright measure` as a user runs it, and against an independent evaluator where one is at hand.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::{TempDir, tempdir};

/// A tent of two squares, one chart, and a third square beside it in UV.
const TENT: &str = "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 1 0\nv 1 1 1\nv 2 1 0\nv 3 0 0\nv 3 1 0\n\
    vt 0 0\nvt .25 0\nvt .5 0\nvt 0 .2\nvt .25 .2\nvt .5 .2\nvt .6 0\nvt .8 0\nvt .8 .2\nvt .6 .2\n\
    f 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\nf 3/7 7/8 8/9 6/10\n";

fn folder() -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    fs::write(folder.path().join("tent.obj"), TENT).expect("writable");
    folder
}

fn measure(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
    command.arg("measure").args(args).current_dir(folder).output().expect("the command starts")
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).expect("standard output is JSON alone")
}

#[test]
fn one_file_is_an_object_and_its_exposure_is_that_of_the_flag() {
    let dir = folder();
    let dir = dir.path();
    let uniform = json(&measure(dir, &["tent.obj", "--json", "--resolution", "64"]));
    assert_eq!((&uniform["obj"], &uniform["exposure"]), (&"tent.obj".into(), &"uniform".into()));
    assert_eq!(
        (&uniform["charts"], &uniform["seam_edges"], &uniform["resolution"]),
        (&2.into(), &1.into(), &64.into())
    );
    assert_eq!((&uniform["flipped_faces"], &uniform["overlapping_faces"]), (&0.into(), &0.into()));
    // The seam turns by 45 degrees, and the ridge, as long, by 90.
    for (key, value) in [("seam_flat_share", 0.0), ("seam_sharp_share", 1.0), ("sharp_seam_cover", 0.5)] {
        assert_eq!(uniform[key], value, "{key}");
    }
    let [visible, noticed] = ["visible_seam_len_norm", "noticed_seam_len_norm"].map(|key| uniform[key].as_f64());
    assert!((noticed.expect("a number") - 0.1 * visible.expect("a number")).abs() < 1e-12);
    let cosine = json(&measure(dir, &["tent.obj", "--json", "--exposure", "cosine"]));
    assert_eq!(cosine["exposure"], "cosine");
    assert_ne!(cosine["seam_ao_len"], uniform["seam_ao_len"]);
    let none = json(&measure(dir, &["tent.obj", "--json", "--exposure", "none"]));
    assert!(none.get("exposure").is_none() && none.get("seam_ao_len").is_none());
    assert!(none.get("noticed_seam_len_norm").is_none() && none["seam_sharp_share"] == 1.0);
    assert_eq!(none["seam_length"], uniform["seam_length"]);
}

#[test]
fn the_table_says_at_its_foot_how_exposure_came_about() {
    let dir = folder();
    let output = measure(dir.path(), &["tent.obj", "--rays", "33"]);
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success() && text.contains("tent.obj"), "{text}");
    assert!(text.contains("33 rays a vertex, every direction alike"), "{text}");
}

#[test]
fn a_file_that_cannot_be_measured_is_left_out_and_decides_the_code() {
    let dir = folder();
    let dir = dir.path();
    fs::write(dir.join("bare.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("writable");
    let output = measure(dir, &["bare.obj", "tent.obj", "missing.obj", "--json", "--exposure", "none"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("bare.obj: no texture coordinates") && message.contains("missing.obj"), "{message}");
    assert_eq!(json(&output).as_array().map(Vec::len), Some(1));
}

#[test]
fn the_report_of_an_unwrap_holds_the_figures_of_measure() {
    let dir = folder();
    let dir = dir.path();
    let args = ["unwrap", "tent.obj", "-o", "out.obj", "--json", "report.json", "-q"];
    let status = Command::new(env!("CARGO_BIN_EXE_seamwright")).args(args).current_dir(dir).status();
    assert!(status.expect("the command starts").success());
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("report.json")).expect("written")).expect("JSON");
    let metrics = &report["metrics"];
    let measured = json(&measure(dir, &["out.obj", "--json", "--exposure", "cosine"]));
    for (key, value) in measured.as_object().expect("an object") {
        assert!(
            key.contains("_ao_") || key.starts_with("visible") || key.starts_with("noticed") || *value == metrics[key],
            "{key}"
        );
    }
    assert_eq!((&metrics["exposure"], &metrics["charts"]), (&"cosine".into(), &report["result"]["charts"]));
    assert_eq!(report["result"]["repaired"]["components"], 1);
    assert_eq!(report["warnings"], serde_json::json!([]));
}

#[test]
fn the_evaluator_agrees_where_it_is_at_hand() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let judge = root.join("../shared/judge/eval_uv.py");
    let python = Command::new("python3").args(["-c", "import numpy, scipy, igl.embree"]).output();
    if !judge.exists() || !python.is_ok_and(|p| p.status.success()) {
        println!("skipped: no evaluator beside the repository, or no Python with numpy, scipy and libigl to run it");
        return;
    }
    let out = Command::new("python3")
        .arg(root.join("tests/judge_agreement.py"))
        .arg("--judge")
        .arg(judge)
        .args(["--unwrap", "--resolution", "512", "--command", env!("CARGO_BIN_EXE_seamwright")])
        .args(["rabbit", "fandisk"].map(|m| root.join("../shared/meshes/bench").join(m).with_extension("obj")))
        .output()
        .expect("Python starts");
    let [said, failed] = [&out.stdout, &out.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(out.status.success(), "{said}{failed}");
}
