//! The command as a user runs it: exit codes, messages, files left behind.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::{TempDir, tempdir};

/// How every PNG file begins.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A folder with one good mesh in it.
fn folder() -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    fs::write(folder.path().join("good.obj"), TRIANGLE).expect("writable");
    folder
}

fn seamwright(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seamwright")).args(args).current_dir(folder).output().expect("the command starts")
}

/// Runs and checks the exit code, every word of `expected` in the message, and that no file has come or changed.
fn fails(folder: &Path, args: &[&str], code: i32, expected: &[&str]) {
    let before = snapshot(folder);
    let output = seamwright(folder, args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    for word in expected {
        assert!(message.contains(word), "{args:?}: '{word}' is not in: {message}");
    }
    assert_eq!(snapshot(folder), before, "{args:?} left something behind");
}

fn snapshot(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).expect("readable").flatten();
    let mut all: Vec<_> = entries
        .map(|e| (e.file_name().to_string_lossy().into_owned(), fs::read(e.path()).unwrap_or_default()))
        .collect();
    all.sort();
    all
}

#[test]
fn a_wrong_command_line_is_code_2_and_names_the_flag() {
    let dir = folder();
    let dir = dir.path();
    fails(dir, &[], 2, &["Usage"]);
    fails(dir, &["unwrap", "good.obj"], 2, &["--output"]);
    let with = |flag: &'static str, value: &'static str, words: &[&str]| {
        fails(dir, &["unwrap", "good.obj", "-o", "out.obj", flag, value], 2, words);
    };
    with("--distortion", "1", &["--distortion", "above 1"]);
    with("--distortion", "nan", &["--distortion"]);
    with("--method", "magic", &["--method", "exact"]);
    with("--charts", "many", &["--charts", "few", "one"]);
    with("--threads", "0", &["--threads"]);
    with("--padding", "600", &["--padding 600", "--size 1024"]);
    with("--padding", "-1", &["invalid value '-1' for '--padding"]);
    with("--sheet", "out.obj", &["--sheet", ".png"]);
    with("--json", "good.obj", &["--json good.obj", "the mesh"]);
    with("--json", "./out.obj", &["--json ./out.obj", "-o"]);
    fails(dir, &["unwrap", "good.obj", "-o", "out.fbx"], 2, &["-o out.fbx", ".obj"]);
}

#[test]
fn an_unreadable_input_is_code_3_and_names_file_and_line() {
    let dir = folder();
    let dir = dir.path();
    let bad = |name: &str, text: &[u8], words: &[&str]| {
        fs::write(dir.join(name), text).expect("writable");
        fails(dir, &["unwrap", name, "-o", "out.obj"], 3, words);
    };
    fails(dir, &["unwrap", "none.obj", "-o", "out.obj"], 3, &["none.obj", "check the path"]);
    fails(dir, &["unwrap", ".", "-o", "out.obj"], 3, &["file ending"]);
    bad("mesh.blend", b"", &["mesh.blend", ".blend", ".obj"]);
    bad("mesh.fbx", b"", &["mesh.fbx", "FBX"]);
    bad("empty.obj", b"", &["empty.obj", "no mesh in it"]);
    bad("lines.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", &["lines.obj", "2 vertices"]);
    bad("nan.obj", b"v 0 0 0\nv nan 0 0\n", &["nan.obj:2:", "not finite"]);
    bad("range.obj", b"v 0 0 0\nf 1 1 2\n", &["range.obj:2:", "vertex index 2", "1 vertices"]);
    bad("zero.obj", b"v 0 0 0\n\nf 1 1 0\n", &["zero.obj:3:", "counts from 1"]);
    bad("word.obj", b"v 0 zero 0\n", &["word.obj:1:", "'zero'"]);
    bad("utf16.obj", b"\xFF\xFEv\0 \x000\0", &["utf16.obj:", "UTF-16"]);
    fails(dir, &["unwrap", "good.obj", "-o", "out.obj", "--keep-seams"], 3, &["good.obj", "--keep-seams", "no UVs"]);
    fails(dir, &["measure", "good.obj"], 3, &["good.obj", "no texture coordinates"]);
    fails(dir, &["render", "good.obj", "-o", "out.png"], 3, &["good.obj", "no texture coordinates"]);
}

#[test]
fn an_output_that_cannot_be_written_is_code_4_before_any_work() {
    let dir = folder();
    let dir = dir.path();
    fs::create_dir(dir.join("folder.obj")).expect("writable");
    fails(dir, &["unwrap", "good.obj", "-o", "no/out.obj"], 4, &["-o no/out.obj", "create its folder"]);
    fails(dir, &["unwrap", "good.obj", "-o", "folder.obj"], 4, &["-o folder.obj", "not a folder"]);
    fails(dir, &["unwrap", "good.obj", "-o", "out.obj", "--json", "no/r.json"], 4, &["--json no/r.json"]);
    fails(dir, &["render", "good.obj", "-o", "no/out.png"], 4, &["-o no/out.png"]);
    fails(dir, &["demo", "-o", "good.obj"], 4, &["good.obj"]);
}

/// The OBJ is complete when the sheet turns out to be a file that nobody can write: a device without room.
#[cfg(target_os = "linux")]
#[test]
fn no_output_falls_on_a_file_that_belongs_to_a_mesh() {
    let dir = folder();
    let dir = dir.path();
    fs::write(dir.join("m.mtl"), "newmtl a\n").expect("writable");
    fs::write(dir.join("m.obj"), format!("mtllib m.mtl\n{TRIANGLE}")).expect("writable");
    fs::write(dir.join("l.seg"), "0\n").expect("writable");
    let with = |words: &[&'static str], expected: &[&str]| fails(dir, &[&["unwrap"], words].concat(), 2, expected);
    with(&["m.obj", "-o", "n.obj", "--json", "m.mtl"], &["--json m.mtl", "a file that the mesh names"]);
    with(&["m.obj", "-o", "n.obj", "--labels", "l.seg", "--json", "l.seg"], &["--json l.seg", "--labels"]);
    with(&["good.obj", "-o", "n.gltf", "--json", "n.bin"], &["--json n.bin", "one that -o writes"]);
    fails(dir, &["transfer", "m.obj", "good.obj", "-o", "n.obj", "--json", "m.mtl"], 2, &["--json m.mtl"]);
    // What an OBJ says of materials stays where it is, and the user is told.
    fs::create_dir(dir.join("far")).expect("writable");
    for (out, expected) in
        [("far/n.obj", "m.mtl is named by it and not copied"), ("n.glb", "what m.mtl says of materials")]
    {
        let done = seamwright(dir, &["unwrap", "m.obj", "-o", out]);
        let message = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success() && message.contains(expected), "{message}");
    }
}

#[test]
fn padding_without_room_is_code_5_where_it_was_asked_for_and_a_warning_else() {
    let dir = folder();
    let dir = dir.path();
    let mut text = String::new();
    for i in 0..400 {
        let (x, first) = (2 * i, 3 * i + 1);
        text += &format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nf {first} {} {}\n", x + 1, first + 1, first + 2);
    }
    fs::write(dir.join("loose.obj"), text).expect("writable");
    let done =
        seamwright(dir, &["unwrap", "loose.obj", "-o", "a.obj", "--size", "64", "--padding", "4", "--json", "a.json"]);
    let message = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(5), "{message}");
    assert!(
        message.contains("--padding 4") && message.contains("400 charts") && message.contains("--size 64"),
        "{message}"
    );
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(dir.join("a.json")).expect("written")).expect("JSON");
    let kept = report["result"]["padding"].as_f64().expect("a number");
    assert!(kept < 4.0 && report["result"]["utilisation"].as_f64().expect("a number") > 0.01, "{report}");
    assert!(seamwright(dir, &["check", "a.obj"]).status.success());
    assert!(seamwright(dir, &["unwrap", "loose.obj", "-o", "a.obj"]).status.success());
}

#[test]
fn a_sheet_that_fails_after_a_good_obj_is_code_4_and_leaves_nothing() {
    let dir = folder();
    let dir = dir.path();
    std::os::unix::fs::symlink("/dev/full", dir.join("full.png")).expect("links are allowed");
    let output = seamwright(dir, &["unwrap", "good.obj", "-o", "out.obj", "--sheet", "full.png", "-q"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(4), "{message}");
    assert!(message.contains("--sheet full.png"), "{message}");
    let mut names: Vec<_> = fs::read_dir(dir).expect("readable").flatten().map(|e| e.file_name()).collect();
    names.sort();
    assert_eq!(names, ["full.png", "good.obj"]);
}

#[test]
fn help_and_version_are_code_0_and_name_the_exit_codes() {
    let dir = folder();
    let help = seamwright(dir.path(), &["--help"]);
    assert!(help.status.success());
    assert!(String::from_utf8_lossy(&help.stdout).contains("130"));
    assert!(seamwright(dir.path(), &["--version"]).status.success());
}

#[test]
fn unwrap_writes_uvs_and_a_report_and_says_nothing_when_quiet() {
    let dir = folder();
    let dir = dir.path();
    let output = seamwright(dir, &["unwrap", "good.obj", "-o", "out.obj", "--json", "-", "--quiet"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), message.as_str()), (Some(0), ""));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("standard output is JSON alone");
    assert_eq!(report["input"]["polygons"], 1);
    assert_eq!(report["result"]["charts"], 1);
    let text = fs::read_to_string(dir.join("out.obj")).expect("written");
    assert!(text.starts_with("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt ") && text.ends_with("f 1/1 2/2 3/3\n"), "{text}");
    assert_eq!(snapshot(dir).len(), 2);
}

#[test]
fn unwrapping_a_file_into_itself_changes_only_its_uvs_and_does_so_once() {
    let dir = folder();
    let dir = dir.path();
    let once = seamwright(dir, &["unwrap", "good.obj", "-o", "good.obj", "--threads", "1"]);
    let first = fs::read(dir.join("good.obj")).expect("there");
    let twice = seamwright(dir, &["unwrap", "good.obj", "-o", "good.obj", "--threads", "3"]);
    assert!(once.status.success() && twice.status.success());
    assert_eq!(fs::read(dir.join("good.obj")).expect("there"), first);
    assert_eq!(snapshot(dir).len(), 1);
}

#[test]
fn the_demo_writes_a_mapped_mesh_a_picture_and_a_report() {
    let dir = folder();
    let output = seamwright(dir.path(), &["demo"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files = snapshot(&dir.path().join("seamwright-demo"));
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["quadruped.json", "quadruped.obj", "quadruped.png"]);
    assert!(String::from_utf8_lossy(&files[1].1).contains("\nvt "));
    assert!(files[2].1.starts_with(PNG));
}

#[test]
fn sheets_are_drawn_by_unwrap_and_from_its_file_alike_with_any_threads() {
    let dir = folder();
    let dir = dir.path();
    let sheet = |name: &'static str, threads: &'static str| {
        let flags = ["unwrap", "good.obj", "-o", "out.obj", "--sheet", name, "--threads", threads, "-q"];
        assert!(seamwright(dir, &flags).status.success());
        fs::read(dir.join(name)).expect("written")
    };
    let once = sheet("a.png", "1");
    assert!(once.starts_with(PNG));
    assert!(once == sheet("b.png", "3"), "threads change the picture");
    let output = seamwright(dir, &["render", "out.obj", "-o", "c.png"]);
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
    assert!(fs::read(dir.join("c.png")).expect("written").starts_with(PNG));
    fails(dir, &["render", "out.obj", "-o", "out.obj"], 2, &["-o out.obj", ".png"]);
}

#[cfg(unix)]
#[test]
fn a_device_as_output_is_written_in_place() {
    let dir = folder();
    let output = seamwright(dir.path(), &["unwrap", "good.obj", "-o", "/dev/null", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(fs::metadata("/dev/null").is_ok_and(|data| !data.is_file()));
}
