//! Learned maps as a user meets them: `unwrap --method neural|hybrid`, saved maps and `apply`, settings files.

use std::collections::HashMap;
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
    fs::write(folder.path().join("s.toml"), "preset = \"draft\"\nsteps = 60\nbatch = 256\n").expect("writable");
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

/// Runs a method with the short settings; gives the OBJ, the map and the report without its times.
fn run(folder: &Path, method: &str, more: &[&str]) -> (Vec<u8>, Vec<u8>, serde_json::Value) {
    let flags = ["-o", "out.obj", "--settings", "s.toml", "--save-map", "m.map", "--json", "r.json", "-q"];
    let args = [&["unwrap", "a.obj", "--method", method][..], &flags, more].concat();
    let output = seamwright(folder, &args);
    // 5: the learned map overlaps, and the atlas is written all the same.
    let code = output.status.code();
    assert!(code == Some(0) || method == "neural" && code == Some(5), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read(folder.join(name)).expect("written");
    (read("out.obj"), read("m.map"), serde_json::from_slice(&read("r.json")).expect("JSON"))
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_threads_and_another_seed_other_weights() {
    let dir = folder();
    let first = run(dir.path(), "neural", &["--threads", "1"]);
    let again = run(dir.path(), "neural", &["--threads", "2"]);
    assert!(first.0 == again.0 && first.1 == again.1, "threads or repetition change the result");
    let other = run(dir.path(), "neural", &["--seed", "7"]);
    assert!(first.1 != other.1, "the seed is not used");
    for (_, _, report) in [&first, &other] {
        assert_eq!(report["metrics"]["faces_without_vt"], 0);
        assert_eq!(report["result"]["flipped"], 0);
        assert_eq!(report["learning"]["maps"], 1);
        assert_eq!(report["learning"]["steps"], 60);
        let curve = report["learning"]["curves"]["target"].as_array().expect("a curve");
        assert!(curve.len() == 60 && curve[59].as_f64() < curve[0].as_f64());
    }
}

#[test]
fn pieces_train_side_by_side_with_the_same_bytes_and_each_gets_its_map() {
    let dir = folder();
    let torus = fs::read_to_string(dir.path().join("a.obj")).expect("a fixture");
    let count = torus.lines().filter(|line| line.starts_with("v ")).count();
    // The same torus twice more, in other sizes, beside the first.
    let mut text = torus.clone();
    for (k, size) in [(1, 0.5), (2, 0.8)] {
        for line in torus.lines() {
            let mut words = line.split_whitespace();
            let line = match words.next() {
                Some("v") => {
                    let x: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
                    format!("v {} {} {}", size * x[0] + 9.0 * f64::from(k), size * x[1], size * x[2])
                }
                Some("f") => {
                    let at = |w: &str| w.split('/').next().and_then(|w| w.parse::<usize>().ok()).expect("an index");
                    words.fold("f".to_string(), |line, w| format!("{line} {}", at(w) + count * k as usize))
                }
                _ => continue,
            };
            text.push_str(&line);
            text.push('\n');
        }
    }
    fs::write(dir.path().join("a.obj"), text).expect("writable");
    for method in ["neural", "hybrid"] {
        let one = run(dir.path(), method, &["--threads", "1"]);
        let three = run(dir.path(), method, &["--threads", "3"]);
        assert!(one.0 == three.0 && one.1 == three.1, "{method}: threads change the result");
        // A third of the faces each, and so a third of the 60 steps.
        assert_eq!((&one.2["learning"]["maps"], &one.2["learning"]["steps"]), (&3.into(), &60.into()));
    }
}

#[test]
fn a_map_is_applied_to_a_finer_mesh() {
    let dir = folder();
    let dir = dir.path();
    let (_, _, report) = run(dir, "neural", &[]);
    let text = fs::read_to_string(dir.join("a.obj")).expect("a fixture");
    fs::write(dir.join("fine.obj"), subdivided(&text)).expect("writable");
    let output = seamwright(dir, &["apply", "fine.obj", "--map", "m.map", "-o", "b.obj", "--json", "b.json", "-q"]);
    assert!(matches!(output.status.code(), Some(0 | 5)), "{}", String::from_utf8_lossy(&output.stderr));
    let fine: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("b.json")).expect("written")).expect("JSON");
    assert_eq!(fine["metrics"]["faces_without_vt"], 0);
    assert_eq!(fine["learning"]["steps"], 0);
    // The map is the same function of space; what tears does so in bands half as many faces wide in proportion.
    for key in ["conformality", "equiareality"] {
        let [a, b] = [&report, &fine].map(|r| r["metrics"][key].as_f64().expect("a number"));
        assert!(b > a - 0.1, "{key}: {a}, finer {b}");
    }
}

/// Every face of an OBJ cut into one quad a corner, by midpoints of edges and a centre.
fn subdivided(obj: &str) -> String {
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut faces = String::new();
    let mut middles = HashMap::new();
    for line in obj.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => points.push([0; 3].map(|_| words.next().and_then(|w| w.parse().ok()).expect("a number"))),
            Some("f") => {
                let index = |w: &str| w.split('/').next().and_then(|w| w.parse::<usize>().ok()).expect("an index") - 1;
                let face: Vec<usize> = words.map(index).collect();
                let mean = |of: &[usize], points: &[[f64; 3]]| {
                    [0, 1, 2].map(|c| of.iter().map(|v| points[*v][c]).sum::<f64>() / of.len() as f64)
                };
                let centre = points.len();
                points.push(mean(&face, &points));
                let mut middle = |a: usize, b: usize| {
                    *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        points.push(mean(&[a, b], &points));
                        points.len() - 1
                    })
                };
                for i in 0..face.len() {
                    let (before, after) = (face[(i + face.len() - 1) % face.len()], face[(i + 1) % face.len()]);
                    let quad = [face[i], middle(face[i], after), centre, middle(before, face[i])].map(|v| v + 1);
                    faces += &format!("f {} {} {} {}\n", quad[0], quad[1], quad[2], quad[3]);
                }
            }
            _ => {}
        }
    }
    points.iter().map(|p| format!("v {} {} {}\n", p[0], p[1], p[2])).collect::<String>() + &faces
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_training_ends_it_with_the_best_map_so_far() {
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
    // Where standard error is no terminal a line is written as a stage ends: that of flattening comes before training.
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
    let before = lines.by_ref().map(|line| line.expect("text")).find(|line| line.starts_with("flatten"));
    assert!(before.is_some(), "no training was reached");
    std::thread::sleep(Duration::from_millis(300));
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
    let said: Vec<_> = lines.map(|line| line.expect("text")).collect();
    let code = child.wait().expect("ends").code();
    assert!(matches!(code, Some(0 | 5)), "{code:?}: {said:?}");
    assert!(said.iter().any(|line| line.contains("training was stopped after")), "{said:?}");
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("r.json")).expect("written")).expect("JSON");
    assert_eq!((&report["learning"]["was_stopped"], &report["metrics"]["faces_without_vt"]), (&true.into(), &0.into()));
    assert!(report["learning"]["steps"].as_u64().is_some_and(|steps| (1..1_000_000).contains(&steps)));
}

#[test]
fn a_hybrid_atlas_keeps_every_guarantee_of_the_exact_stages() {
    let dir = folder();
    for seed in ["0", "5"] {
        let (_, _, report) = run(dir.path(), "hybrid", &["--seed", seed]);
        let (result, metrics) = (&report["result"], &report["metrics"]);
        assert_eq!((&result["flipped"], &result["overlapping"]), (&0.into(), &0.into()));
        assert_eq!((&metrics["closed_or_handled_charts"], &metrics["faces_without_vt"]), (&0.into(), &0.into()));
        assert!(result["distortion"].as_f64() <= Some(1.0250001));
    }
}

#[test]
fn a_saved_map_gives_nearly_the_same_atlas_without_training_and_a_damaged_one_is_refused() {
    let dir = folder();
    let dir = dir.path();
    let (_, map, report) = run(dir, "neural", &[]);
    let output = seamwright(dir, &["apply", "a.obj", "--map", "m.map", "-o", "b.obj", "--json", "b.json", "-q"]);
    assert!(matches!(output.status.code(), Some(0 | 5)), "{}", String::from_utf8_lossy(&output.stderr));
    let applied: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("b.json")).expect("written")).expect("JSON");
    // Weights lose 13 of 24 bits: faces at the limit of what is torn may fall on its other side.
    for key in ["conformality", "equiareality"] {
        let [a, b] = [&report, &applied].map(|r| r["metrics"][key].as_f64().expect("a number"));
        assert!((a - b).abs() < 0.05, "{key}: {a} and {b}");
    }
    assert_eq!((&applied["learning"]["steps"], &applied["learning"]["preset"]), (&0.into(), &"given".into()));
    fs::write(dir.join("short.map"), &map[..map.len() - 1]).expect("writable");
    let mut turned = map.clone();
    turned[500] ^= 1;
    fs::write(dir.join("turned.map"), &turned).expect("writable");
    fails(dir, &["apply", "a.obj", "--map", "short.map", "-o", "c.obj"], 3, &["short.map", "damaged", "bytes"]);
    fails(dir, &["apply", "a.obj", "--map", "turned.map", "-o", "c.obj"], 3, &["turned.map", "checksum"]);
    fails(dir, &["apply", "a.obj", "--map", "a.obj", "-o", "c.obj"], 3, &["not a map"]);
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
    fails(dir, &["unwrap", "a.obj", "-o", "b.obj", "--steps", "5"], 2, &["--steps", "--method neural"]);
}
