//! Learned maps as a user meets them: `unwrap --method neural`, saved maps and `apply`, settings files, the published training.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::{TempDir, tempdir};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)
}

fn folder() -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    fs::copy(fixture("torus.obj"), folder.path().join("a.obj")).expect("writable");
    fs::write(folder.path().join("s.toml"), "preset = \"draft\"\nsteps = 60\n").expect("writable");
    folder
}

fn seamwright(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seamwright")).args(args).current_dir(folder).output().expect("the command starts")
}

fn fails(folder: &Path, args: &[&str], code: i32, words: &[&str]) {
    let output = seamwright(folder, args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    words.iter().for_each(|word| assert!(message.contains(word), "{args:?}: '{word}' is not in: {message}"));
}

/// Learns with the short settings; gives the OBJ, the map and the report.
fn run(folder: &Path, more: &[&str]) -> (Vec<u8>, Vec<u8>, serde_json::Value) {
    let flags = ["-o", "out.obj", "--settings", "s.toml", "--save-map", "m.map", "--json", "r.json", "-q"];
    let args = [&["unwrap", "a.obj", "--method", "neural"][..], &flags, more].concat();
    let output = seamwright(folder, &args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read(folder.join(name)).expect("written");
    (read("out.obj"), read("m.map"), serde_json::from_slice(&read("r.json")).expect("JSON"))
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_threads_and_another_seed_other_weights() {
    let dir = folder();
    let first = run(dir.path(), &["--threads", "1"]);
    let again = run(dir.path(), &["--threads", "2"]);
    assert!(first.0 == again.0 && first.1 == again.1, "threads or repetition change the result");
    let other = run(dir.path(), &["--seed", "7"]);
    assert!(first.1 != other.1, "the seed is not used");
    for (_, _, report) in [&first, &other] {
        assert_eq!(report["metrics"]["faces_without_vt"], 0);
        assert_eq!(report["learning"]["steps"], 60);
        let curve = report["learning"]["curves"]["jacobians"].as_array().expect("a curve");
        assert!(curve.len() == 60 && curve[47].as_f64() < curve[0].as_f64());
    }
}

#[test]
fn the_atlas_keeps_every_guarantee_however_little_was_learned() {
    let dir = folder();
    for steps in ["1", "20", "300"] {
        let (_, _, report) = run(dir.path(), &["--steps", steps]);
        let (result, metrics) = (&report["result"], &report["metrics"]);
        assert_eq!((&result["flipped"], &result["overlapping"]), (&0.into(), &0.into()), "{steps}");
        assert_eq!((&metrics["closed_or_handled_charts"], &metrics["faces_without_vt"]), (&0.into(), &0.into()));
        assert!(result["distortion"].as_f64() <= Some(1.0250001), "{steps}: {}", result["distortion"]);
    }
}

#[test]
fn a_slit_that_the_exact_stages_close_stays_closed_and_a_saved_map_knows_it() {
    let dir = folder();
    let dir = dir.path();
    fs::copy(fixture("solids/plate_x4_y3_b8_r0.2_d0.2_quad.obj"), dir.join("a.obj")).expect("a fixture");
    let noticed = |report: &serde_json::Value| report["metrics"]["noticed_seam_len_norm"].as_f64().expect("a length");
    let output = seamwright(dir, &["unwrap", "a.obj", "-o", "exact.obj", "--json", "e.json", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let exact: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("e.json")).expect("written")).expect("JSON");
    // Few steps, after which nearly all is corrected; and many.
    for steps in ["20", "400"] {
        let (obj, _, report) = run(dir, &["--steps", steps]);
        // The same seams.
        assert!((noticed(&report) - noticed(&exact)).abs() <= 1e-9 * noticed(&exact), "{steps}");
        let output = seamwright(dir, &["apply", "a.obj", "--map", "m.map", "-o", "out.obj", "-q"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(fs::read(dir.join("out.obj")).expect("written") == obj, "{steps}");
    }
}

#[test]
fn copies_are_learned_once_and_weigh_in_the_bound_as_often_as_they_are_there() {
    let dir = folder();
    fs::copy(fixture("faults/copies.obj"), dir.path().join("a.obj")).expect("a fixture");
    for steps in ["5", "20", "200"] {
        let (_, _, report) = run(dir.path(), &["--steps", steps]);
        let map = &report["learning"]["map"];
        assert_eq!((&map["charts"], &map["faces"], &map["other_faces"]), (&2.into(), &8.into(), &0.into()), "{steps}");
        assert!(report["result"]["distortion"].as_f64() <= Some(1.0250001), "{steps}: {}", report["result"]);
    }
}

#[test]
fn the_network_itself_holds_the_map_of_a_torus_where_it_is_given_the_steps() {
    let dir = folder();
    let args = ["unwrap", "a.obj", "-o", "out.obj", "--method", "neural", "--steps", "800", "--json", "r.json", "-q"];
    let output = seamwright(dir.path(), &args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.path().join("r.json")).expect("written")).expect("JSON");
    let map = &report["learning"]["map"];
    let faces = map["faces"].as_u64().expect("a count");
    // What is asked of a map before anything else is done to it.
    assert!(map["own_distortion"].as_f64() <= Some(1.05), "{map}");
    assert!(map["own_flipped"].as_u64().is_some_and(|flipped| 1000 * flipped <= faces), "{map}");
    assert!(map["moved_texels"][1].as_f64() <= Some(2.0), "{map}");
}

#[test]
fn the_published_training_counts_what_it_tears() {
    let dir = folder();
    fs::write(dir.path().join("p.toml"), "preset = \"paper\"\nwidth = 16\ncode = 4\nbatch = 128\n").expect("writable");
    let flags = ["--settings", "p.toml", "--steps", "30", "--json", "r.json", "-q"];
    let args = [&["unwrap", "a.obj", "-o", "b.obj", "--method", "neural"][..], &flags].concat();
    let output = seamwright(dir.path(), &args);
    // 5: the published map overlaps, and the atlas is written all the same.
    assert!(matches!(output.status.code(), Some(0 | 5)), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.path().join("r.json")).expect("written")).expect("JSON");
    let learning = &report["learning"];
    assert_eq!((&learning["steps"], &learning["published"]["maps"]), (&30.into(), &1.into()));
    assert!(learning["curves"]["wrap"].as_array().is_some_and(|curve| curve.len() == 30));
    assert_eq!((&report["result"]["flipped"], &report["metrics"]["faces_without_vt"]), (&0.into(), &0.into()));
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_training_ends_it_with_what_was_learned() {
    let dir = folder();
    let dir = dir.path();
    fs::write(dir.join("s.toml"), "preset = \"draft\"\nsteps = 1000000\n").expect("writable");
    let args = ["unwrap", "a.obj", "-o", "b.obj", "--method", "neural", "--settings", "s.toml", "--json", "r.json"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_seamwright"))
        .args(args)
        .current_dir(dir)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    // Where standard error is no terminal a line is written as a stage ends: that of seams comes before training.
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
    let before = lines.by_ref().map(|line| line.expect("text")).find(|line| line.starts_with("seams"));
    assert!(before.is_some(), "no training was reached");
    std::thread::sleep(Duration::from_millis(500));
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
    let said: Vec<_> = lines.map(|line| line.expect("text")).collect();
    let code = child.wait().expect("ends").code();
    assert!(code == Some(0), "{code:?}: {said:?}");
    assert!(said.iter().any(|line| line.contains("training was stopped after")), "{said:?}");
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("r.json")).expect("written")).expect("JSON");
    assert_eq!((&report["learning"]["was_stopped"], &report["metrics"]["faces_without_vt"]), (&true.into(), &0.into()));
    assert!(report["learning"]["steps"].as_u64().is_some_and(|steps| (1..1_000_000).contains(&steps)));
}

#[test]
fn a_saved_map_gives_the_atlas_again_to_the_byte_and_a_damaged_or_foreign_one_is_refused() {
    let dir = folder();
    let dir = dir.path();
    // 3: nearly all is corrected; 400: nearly all is the network's.
    for steps in ["3", "400"] {
        let (obj, map, _) = run(dir, &["--steps", steps]);
        let output = seamwright(dir, &["apply", "a.obj", "--map", "m.map", "-o", "out.obj", "--json", "b.json", "-q"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(fs::read(dir.join("out.obj")).expect("written") == obj, "{steps}");
        let report: serde_json::Value =
            serde_json::from_slice(&fs::read(dir.join("b.json")).expect("written")).expect("JSON");
        assert_eq!((&report["learning"]["steps"], &report["learning"]["preset"]), (&0.into(), &"given".into()));
        fs::write(dir.join("short.map"), &map[..map.len() - 1]).expect("writable");
        let mut turned = map.clone();
        turned[500] ^= 1;
        fs::write(dir.join("turned.map"), &turned).expect("writable");
    }
    fails(dir, &["apply", "a.obj", "--map", "short.map", "-o", "c.obj"], 3, &["short.map", "damaged", "bytes"]);
    fails(dir, &["apply", "a.obj", "--map", "turned.map", "-o", "c.obj"], 3, &["turned.map", "checksum"]);
    fails(dir, &["apply", "a.obj", "--map", "a.obj", "-o", "c.obj"], 3, &["not a map"]);
    fs::copy(fixture("cube.obj"), dir.join("cube.obj")).expect("a fixture");
    fails(dir, &["apply", "cube.obj", "--map", "m.map", "-o", "c.obj"], 3, &["cube.obj", "not the mesh", "transfer"]);
    assert!(!dir.join("c.obj").exists());
}

#[test]
fn wrong_flags_and_settings_are_refused_by_name_and_line() {
    let dir = folder();
    let dir = dir.path();
    fs::write(dir.join("bad.toml"), "steps = 10\nstep = 10\n").expect("writable");
    let neural = ["unwrap", "a.obj", "-o", "b.obj", "--method", "neural"];
    fails(dir, &[&neural[..], &["--settings", "bad.toml"]].concat(), 2, &["bad.toml:2", "step"]);
    fails(dir, &[&neural[..], &["--settings", "none.toml"]].concat(), 3, &["none.toml"]);
    fails(dir, &[&neural[..], &["--preset", "fast"]].concat(), 2, &["draft, standard or paper"]);
    fails(dir, &[&neural[..], &["--save-map", "a.obj"]].concat(), 2, &["--save-map", "the same file"]);
    fails(dir, &[&neural[..], &["--visibility", "1"]].concat(), 2, &["--visibility", "--preset paper"]);
    fails(dir, &[&neural[..], &["--preset", "paper", "--save-map", "m.map"]].concat(), 2, &["--save-map", "preset"]);
    fails(dir, &["unwrap", "a.obj", "-o", "b.obj", "--steps", "5"], 2, &["--steps", "--method neural"]);
    fails(dir, &["unwrap", "a.obj", "-o", "b.obj", "--method", "hybrid", "--steps", "5"], 2, &["--steps", "hybrid"]);
}
