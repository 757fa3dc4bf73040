//! Parts as a user meets them: `segment`, `unwrap --parts` and `--labels`, `measure --reference`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::{TempDir, tempdir};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)
}

/// A folder with a fixture and its known parts.
fn folder() -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    for name in ["mug.obj", "mug.seg", "quadruped.obj", "quadruped.seg"] {
        fs::copy(fixture(name), folder.path().join(name)).expect("writable");
    }
    folder
}

fn seamwright(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seamwright")).args(args).current_dir(folder).output().expect("the command starts")
}

fn succeeds(folder: &Path, args: &[&str]) -> Output {
    let output = seamwright(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn fails(folder: &Path, args: &[&str], code: i32, words: &[&str]) {
    let output = seamwright(folder, args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    for word in words {
        assert!(message.contains(word), "{args:?}: '{word}' is not in: {message}");
    }
}

fn json(text: &[u8]) -> serde_json::Value {
    serde_json::from_slice(text).expect("JSON")
}

/// Agreement of the labels in a file with the mug's known parts.
fn agreement(folder: &Path, labels: &str, reference: &str) -> serde_json::Value {
    let flags = ["--json", "--exposure", "none", "--resolution", "0"];
    let args = [&["measure", "mug.obj", "--labels", labels, "--reference", reference][..], &flags].concat();
    json(&succeeds(folder, &args).stdout)["agreement"]["mean"].clone()
}

#[test]
fn segment_writes_the_same_parts_in_every_form() {
    let dir = folder();
    let dir = dir.path();
    for name in ["out.seg", "out.json", "out.ply", "out.glb"] {
        succeeds(dir, &["segment", "mug.obj", "-o", name, "--parts", "3", "-q", "--sheet", "out.png"]);
        let figures = agreement(dir, name, "out.seg");
        assert_eq!((&figures["hamming"], &figures["rand_index"]), (&0.0.into(), &1.0.into()), "{name}");
        assert_eq!(figures["cut_discrepancy"], 0.0, "{name}");
    }
    let labels = fs::read_to_string(dir.join("out.seg")).expect("written");
    assert_eq!(labels.lines().count(), 6486);
    let mut known: Vec<&str> = labels.lines().collect();
    known.sort_unstable();
    known.dedup();
    assert!(known.len() > 1, "one part has no borders to compare");
    assert!(fs::read(dir.join("out.png")).expect("written").starts_with(b"\x89PNG"));
    let once = fs::read(dir.join("out.ply")).expect("written");
    succeeds(dir, &["segment", "mug.obj", "-o", "out.ply", "--parts", "3", "-q", "--threads", "1"]);
    assert!(once == fs::read(dir.join("out.ply")).expect("written"), "threads change the parts");
}

#[test]
fn charts_are_within_parts_and_the_report_has_their_tree() {
    let dir = folder();
    let dir = dir.path();
    let flags = ["-o", "out.obj", "--labels", "mug.seg", "--groups", "--json", "-", "-q", "--packing", "grid"];
    let report = json(&succeeds(dir, &[&["unwrap", "mug.obj"][..], &flags].concat()).stdout);
    let parts = report["parts"].as_array().expect("a list");
    assert_eq!((parts.len(), &report["settings"]["parts"]), (3, &"mug.seg".into()));
    let charts: Vec<_> = parts.iter().flat_map(|part| part["charts"].as_array().expect("a list")).collect();
    assert_eq!(charts.len() as u64, report["result"]["charts"].as_u64().expect("a count"));
    let (written, known) = (
        fs::read_to_string(dir.join("out.obj")).expect("written"),
        fs::read_to_string(dir.join("mug.seg")).expect("there"),
    );
    // Every face stands in the group of a chart of its part.
    let (mut group, mut faces) = ("", known.lines());
    for line in written.lines() {
        if let Some(name) = line.strip_prefix("g ") {
            group = name;
        } else if line.starts_with("f ") {
            let label = faces.next().expect("a label a face");
            let part = parts.iter().find(|p| p["label"] == label).expect("a part of that label");
            let own = part["charts"].as_array().expect("a list").iter().any(|c| c["name"] == group);
            assert!(own, "a face of label {label} in {group}");
        }
    }
    let metrics = &report["metrics"];
    for figure in ["closed_or_handled_charts", "exact_flipped_faces", "overlapping_faces", "faces_without_vt"] {
        assert_eq!(metrics[figure], 0, "{figure}");
    }
    let flags = ["--reference", "mug.seg", "--json", "--exposure", "none", "--resolution", "0"];
    let measured = json(&succeeds(dir, &[&["measure", "out.obj"][..], &flags].concat()).stdout);
    // A chart lies in one part, so nothing of it is a false alarm.
    assert_eq!(
        (&measured["agreement"]["compared"], &measured["agreement"]["mean"]["false_alarm_aw"]),
        (&"charts".into(), &0.0.into())
    );
}

#[test]
fn the_same_part_of_a_similar_shape_gets_the_same_cell() {
    let dir = folder();
    let dir = dir.path();
    // A little wider, and other numbers for the same parts.
    let wider: String = fs::read_to_string(dir.join("quadruped.obj")).expect("there").lines().map(stretched).collect();
    fs::write(dir.join("wider.obj"), wider).expect("writable");
    let known = fs::read_to_string(dir.join("quadruped.seg")).expect("there");
    let turned: String = known.lines().map(|l| format!("{}\n", 100 - l.parse::<i32>().expect("a label"))).collect();
    fs::write(dir.join("wider.seg"), turned).expect("writable");
    let cells = |mesh: &str, labels: &str, turn: &dyn Fn(i64) -> i64| {
        let flags = ["-o", "out.obj", "--packing", "grid", "--json", "-", "-q", "--rays", "64"];
        let report = json(&succeeds(dir, &[&["unwrap", mesh, "--labels", labels][..], &flags].concat()).stdout);
        let cell = |part: &serde_json::Value| {
            let label: i64 = part["label"].as_str().expect("a word").parse().expect("a number");
            (turn(label), part["charts"][0]["chart"].as_u64())
        };
        let mut cells: Vec<_> = report["parts"].as_array().expect("a list").iter().map(cell).collect();
        cells.sort_unstable();
        cells
    };
    assert_eq!(cells("quadruped.obj", "quadruped.seg", &|l| l), cells("wider.obj", "wider.seg", &|l| 100 - l));
}

/// A line of an OBJ with vertices 3 % wider in x.
fn stretched(line: &str) -> String {
    match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["v", x, y, z] => format!("v {} {y} {z}\n", 1.03 * x.parse::<f64>().expect("a number")),
        _ => format!("{line}\n"),
    }
}

#[test]
fn labels_of_a_reordered_mesh_are_matched_by_place() {
    let dir = folder();
    let dir = dir.path();
    succeeds(dir, &["segment", "mug.obj", "-o", "out.ply", "--parts", "3", "-q"]);
    succeeds(dir, &["segment", "mug.obj", "-o", "out.seg", "--parts", "3", "-q"]);
    // The same PLY with its faces from last to first.
    let text = fs::read_to_string(dir.join("out.ply")).expect("written");
    let lines: Vec<&str> = text.lines().collect();
    let faces = lines.len() - 6486;
    let turned = [&lines[..faces], &lines[faces..].iter().rev().copied().collect::<Vec<_>>()].concat().join("\n");
    fs::write(dir.join("turned.ply"), turned).expect("writable");
    assert_eq!(agreement(dir, "turned.ply", "out.seg")["hamming"], 0.0);
    fails(
        dir,
        &["unwrap", "quadruped.obj", "-o", "out.obj", "--labels", "turned.ply"],
        3,
        &["6028 of the 6028 faces", "6486"],
    );
}

#[test]
fn labels_that_do_not_fit_are_refused_with_the_counts() {
    let dir = folder();
    let dir = dir.path();
    let with = |labels: &str, words: &[&str]| {
        fails(dir, &["unwrap", "mug.obj", "-o", "out.obj", "--labels", labels], 3, words);
    };
    with("quadruped.seg", &["--labels quadruped.seg", "6028 labels", "mug.obj has 6486 faces"]);
    with("none.seg", &["none.seg", "check the path"]);
    with("mug.obj", &["--labels mug.obj", ".seg, .json, .ply and .glb"]);
    fs::write(dir.join("bad.json"), "{\"0\": 1, \"9\": 2}").expect("writable");
    with("bad.json", &["bad.json", "6484 of the 6486 faces"]);
    fails(
        dir,
        &["measure", "mug.obj", "--labels", "mug.seg", "--reference", "quadruped.seg"],
        3,
        &["--reference quadruped.seg", "6028"],
    );
    assert!(!dir.join("out.obj").exists());
}

#[test]
fn flags_that_contradict_each_other_are_code_2() {
    let dir = folder();
    let dir = dir.path();
    let unwrap = ["unwrap", "mug.obj", "-o", "out.obj"];
    fails(dir, &[&unwrap[..], &["--labels", "mug.seg", "--parts", "3"]].concat(), 2, &["--labels", "--parts"]);
    fails(dir, &[&unwrap[..], &["--parts", "0"]].concat(), 2, &["--parts", "off, auto"]);
    fails(dir, &["segment", "mug.obj", "-o", "out.seg", "--parts", "off"], 2, &["--parts", "auto"]);
    fails(dir, &["segment", "mug.obj", "-o", "out.txt"], 2, &["-o out.txt", ".seg"]);
    fails(dir, &["segment", "mug.obj", "-o", "out.seg", "--sheet", "out.jpg"], 2, &["--sheet out.jpg", ".png"]);
    fails(dir, &["measure", "mug.obj", "--labels", "mug.seg"], 2, &["--reference"]);
    fails(dir, &["measure", "mug.obj", "quadruped.obj", "--reference", "mug.seg"], 2, &["--reference", "2 files"]);
    fails(dir, &["measure", "mug.obj", "--reference", "mug.seg"], 3, &["no texture coordinates"]);
}

#[test]
fn several_references_are_averaged() {
    let dir = folder();
    let dir = dir.path();
    let one = "0\n".repeat(6486);
    fs::write(dir.join("one.seg"), one).expect("writable");
    let flags = ["--json", "--exposure", "none", "--resolution", "0"];
    let args =
        [&["measure", "mug.obj", "--labels", "mug.seg", "--reference", "mug.seg", "one.seg"][..], &flags].concat();
    let agreement = json(&succeeds(dir, &args).stdout)["agreement"].clone();
    let rand = |i: usize| agreement["references"][i]["rand_index"].as_f64().expect("a number");
    assert_eq!((rand(0), agreement["labels"].as_u64()), (1.0, Some(3)));
    // One half of a sum of two: exact.
    assert_eq!(agreement["mean"]["rand_index"].as_f64(), Some(0.5 * (1.0 + rand(1))));
}
