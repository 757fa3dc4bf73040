//! The judge against an independent evaluator: recorded figures always, the evaluator itself where it is at hand.

use seamwright::figures::measure::measure;
use seamwright::figures::record::json;
use seamwright::figures::sampled::{SampledExposure, Weighting};
use seamwright_tests::plain_obj::PlainObj;
use serde_json::Value;
use std::{fs, path::Path, process::Command};

/// As judge_agreement.py: counts are equal, reals agree to 1e-6 relative, 1e-9 absolute near zero. Both sides compute in
/// f64 from the same formulas; what differs is the order of sums and the last digit of atan2.
const RELATIVE: f64 = 1e-6;
const ABSOLUTE: f64 = 1e-9;

fn agree(theirs: &Value, ours: &Value) -> bool {
    match (theirs, ours) {
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| agree(a, b)),
        (Value::Number(a), Value::Number(b)) if a.is_u64() => a.as_u64() == b.as_u64(),
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= ABSOLUTE + RELATIVE * a.abs()
        }
        _ => theirs == ours,
    }
}

#[test]
fn recorded_figures_of_hostile_maps_are_reproduced() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/judge");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "obj"));
    files.sort();
    assert_eq!(files.len(), 7);
    for path in files {
        let mesh = PlainObj::parse(&fs::read_to_string(&path).unwrap());
        let formula = |p: &glam::DVec3| (1.0 / (1.0 + p.x * p.x + 2.0 * p.y * p.y + 3.0 * p.z * p.z)) as f32;
        let values: Vec<f32> = mesh.positions.iter().map(formula).collect();
        let exposure = SampledExposure { values: &values, weighting: Weighting::Uniform };
        let record = measure("", mesh.polygons(), Some(exposure), 256).unwrap();
        let ours: Value = serde_json::from_str(&json(&record)).unwrap();
        let text = fs::read_to_string(path.with_extension("json")).unwrap();
        let theirs: Value = serde_json::from_str(&text).unwrap();
        for (key, value) in theirs.as_object().unwrap() {
            assert!(agree(value, &ours[key]), "{}: {key}: {value} recorded, {} measured", path.display(), ours[key]);
        }
    }
}

#[test]
fn the_evaluator_agrees_on_real_meshes_where_it_is_at_hand() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = tests.join("../../shared");
    let judge = shared.join("judge/eval_uv.py");
    let python = Command::new("python3").args(["-c", "import numpy, scipy"]).output();
    if !judge.exists() || !python.is_ok_and(|p| p.status.success()) {
        println!("skipped: no evaluator beside the repository, or no Python with numpy and scipy to run it");
        return;
    }
    let meshes = ["bench/spot.obj", "bench/bob.obj", "hard/xa_cube.obj", "hard/tm_negative_indices.obj"];
    let out = Command::new("python3")
        .arg(tests.join("judge_agreement.py"))
        .arg("--judge")
        .arg(judge)
        .args(["--no-ao", "--resolution", "512", "--runner", env!("CARGO_BIN_EXE_measure_plain")])
        .args(meshes.map(|m| shared.join("meshes").join(m)))
        .output()
        .unwrap();
    let [said, failed] = [&out.stdout, &out.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(out.status.success(), "{said}{failed}");
}
