//! `seamwright transfer` as a user runs it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::tempdir;

fn seamwright(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seamwright")).args(args).current_dir(folder).output().expect("the command starts")
}

/// A cube of unit size in quads, moved along x, and the same in triangles.
fn cube(x: f64, triangles: bool) -> String {
    let mut text = String::new();
    for v in 0..8 {
        text += &format!("v {} {} {}\n", x + f64::from(v & 1), v >> 1 & 1, v >> 2);
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        text += &if triangles { format!("f {a} {b} {c}\nf {a} {c} {d}\n") } else { format!("f {a} {b} {c} {d}\n") };
    }
    text
}

#[test]
fn the_atlas_goes_to_the_other_mesh_with_a_report_and_a_picture() {
    let dir = tempdir().expect("a temporary folder");
    let dir = dir.path();
    fs::write(dir.join("a.obj"), cube(0.0, false)).expect("writable");
    fs::write(dir.join("b.obj"), cube(0.0, true)).expect("writable");
    assert!(seamwright(dir, &["unwrap", "a.obj", "-o", "a_uv.obj", "-q"]).status.success());
    let done =
        seamwright(dir, &["transfer", "a_uv.obj", "b.obj", "-o", "b_uv.obj", "--json", "r.json", "--sheet", "b.png"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("r.json")).expect("written")).expect("JSON");
    let result = &report["result"];
    assert_eq!(result["within_two_texels"], 1.0, "{report}");
    assert_eq!((&result["flipped_faces"], &result["overlapping_faces"]), (&0.into(), &0.into()));
    assert_eq!(result["charts"], result["source_charts"]);
    assert!(fs::read(dir.join("b.png")).expect("written").starts_with(b"\x89PNG"));
    let kept = seamwright(dir, &["check", "b_uv.obj", "--input", "b.obj"]);
    assert!(kept.status.success(), "{}", String::from_utf8_lossy(&kept.stdout));
}

#[test]
fn what_is_left_of_a_mesh_keeps_its_uvs() {
    let dir = tempdir().expect("a temporary folder");
    let dir = dir.path();
    fs::write(dir.join("a.obj"), cube(0.0, false)).expect("writable");
    let rest: Vec<String> = cube(0.0, false).lines().map(String::from).filter(|line| line != "f 1 2 6 5").collect();
    fs::write(dir.join("b.obj"), rest.join("\n")).expect("writable");
    assert!(seamwright(dir, &["unwrap", "a.obj", "-o", "a_uv.obj", "-q"]).status.success());
    let done = seamwright(dir, &["transfer", "a_uv.obj", "b.obj", "-o", "b_uv.obj", "--json", "r.json"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("r.json")).expect("written")).expect("JSON");
    assert_eq!((&report["result"]["copied"], &report["result"]["moved_faces"]), (&true.into(), &0.into()));
    assert_eq!(report["warnings"], serde_json::json!([]));
    // Every corner's UV, face by face.
    let uvs = |name: &str| -> Vec<(String, Vec<String>)> {
        let text = fs::read_to_string(dir.join(name)).expect("written");
        let vt: Vec<&str> = text.lines().filter(|line| line.starts_with("vt ")).collect();
        let of =
            |word: &str| vt[word.split('/').nth(1).expect("a UV").parse::<usize>().expect("a number") - 1].to_string();
        let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
        let places =
            |face: &str| face.split(' ').map(|word| word.split('/').next().unwrap_or("")).collect::<Vec<_>>().join(" ");
        faces.map(|face| (places(face), face.split(' ').map(of).collect())).collect()
    };
    let mut expected = uvs("a_uv.obj");
    expected.retain(|(face, _)| face != "1 2 6 5");
    assert_eq!(uvs("b_uv.obj"), expected);
}

#[test]
fn what_cannot_be_carried_over_has_its_code_and_leaves_nothing() {
    let dir = tempdir().expect("a temporary folder");
    let dir = dir.path();
    fs::write(dir.join("a.obj"), cube(0.0, false)).expect("writable");
    fs::write(dir.join("far.obj"), cube(3.0, false)).expect("writable");
    assert!(seamwright(dir, &["unwrap", "a.obj", "-o", "a_uv.obj", "-q"]).status.success());
    let fails = |args: &[&str], code: i32, words: &[&str]| {
        let output = seamwright(dir, args);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
        assert!(words.iter().all(|w| message.contains(w)), "{args:?}: {message}");
        assert!(!dir.join("out.obj").exists());
    };
    fails(
        &["transfer", "a.obj", "far.obj", "-o", "out.obj"],
        3,
        &["a.obj", "texture coordinates", "seamwright unwrap"],
    );
    fails(&["transfer", "a_uv.obj", "far.obj", "-o", "out.obj"], 3, &["far.obj", "a_uv.obj", "% of its size"]);
    fails(&["transfer", "a_uv.obj", "far.obj", "-o", "a_uv.obj"], 2, &["-o a_uv.obj", "the mesh with the atlas"]);
    fails(&["transfer", "-", "-", "-o", "out.obj"], 2, &["standard input holds one mesh"]);
}
