//! The command between others, and short of what it needs: standard input and output, reports of failures, memory.

use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::{TempDir, tempdir};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn folder() -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    fs::write(folder.path().join("good.obj"), TRIANGLE).expect("writable");
    folder
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)
}

fn with_input(folder: &Path, args: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
    let pipes =
        command.args(args).current_dir(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = pipes.spawn().expect("the command starts");
    // What is refused is not read.
    let _ = child.stdin.take().expect("a pipe").write_all(input);
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_stream_gives_what_a_file_gives() {
    let folder = folder();
    let folder = folder.path();
    let glb = fs::read(fixture("faults/rigged.glb")).expect("a fixture");
    fs::write(folder.join("good.glb"), &glb).expect("writable");
    for (name, bytes, format) in [("good.obj", TRIANGLE.as_bytes(), "obj"), ("good.glb", &glb, "glb")] {
        let output = format!("file.{format}");
        assert!(with_input(folder, &["unwrap", name, "-o", &output, "-q"], b"").status.success());
        let file = fs::read(folder.join(&output)).expect("written");
        let through = with_input(folder, &["unwrap", "-", "-o", "-", "--format", format, "-q"], bytes);
        assert_eq!(
            (through.status.code(), through.stdout == file),
            (Some(0), true),
            "{format}: {}",
            String::from_utf8_lossy(&through.stderr)
        );
        // Without --format, standard output is what came in.
        assert!(with_input(folder, &["unwrap", name, "-o", "-", "-q"], b"").stdout == file);
    }
    // From one to another; no .mtl falls into the folder.
    let obj = with_input(folder, &["unwrap", "good.glb", "-o", "-", "--format", "obj", "-q"], b"");
    assert!(obj.status.success() && obj.stdout.starts_with(b"v "), "{}", String::from_utf8_lossy(&obj.stderr));
    let names = || fs::read_dir(folder).expect("readable").count();
    assert_eq!(names(), 4);
    let measured = with_input(folder, &["measure", "-", "--format", "obj", "--json"], &obj.stdout);
    assert!(serde_json::from_slice::<Value>(&measured.stdout).is_ok_and(|value| value["faces"].as_u64() > Some(30)));
    let code = |args: &[&str]| with_input(folder, args, TRIANGLE.as_bytes()).status.code();
    assert_eq!(code(&["unwrap", "-", "-o", "b.obj"]), Some(2));
    assert_eq!(code(&["unwrap", "-", "-o", "-", "--format", "obj", "--json", "-"]), Some(2));
    assert_eq!(code(&["unwrap", "good.obj", "-o", "b.obj", "--format", "obj"]), Some(2));
    assert_eq!(code(&["unwrap", "-", "-o", "-", "--format", "gltf"]), Some(3));
    assert_eq!(code(&["unwrap", "good.obj", "-o", "-", "--format", "gltf"]), Some(2));
    assert_eq!(names(), 4);
}

#[test]
fn a_mesh_that_cannot_be_read_has_its_report() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("bad.obj"), "v 0 0 0\nv nan 0 0\n").expect("writable");
    let told = |output: &[u8]| {
        let report: Value = serde_json::from_slice(output).expect("JSON");
        assert_eq!((&report["code"], &report["input"]["file"]), (&Value::from(3), &Value::from("bad.obj")));
        assert!(report["error"].as_str().is_some_and(|text| text.contains("bad.obj:2:")), "{report}");
    };
    let output = with_input(folder, &["unwrap", "bad.obj", "-o", "out.obj", "--json", "-"], b"");
    assert_eq!(output.status.code(), Some(3));
    told(&output.stdout);
    let output = with_input(folder, &["unwrap", "bad.obj", "-o", "out.obj", "--json", "report.json"], b"");
    assert_eq!(
        (output.status.code(), output.stdout.is_empty(), folder.join("out.obj").exists()),
        (Some(3), true, false)
    );
    told(&fs::read(folder.join("report.json")).expect("written"));
}

/// Runs the command by a shell that does `before`, with `after` behind it.
#[cfg(target_os = "linux")]
fn shell(folder: &Path, before: &str, args: &str, after: &str) -> Output {
    let line = format!("{before} exec '{}' {args} {after}", env!("CARGO_BIN_EXE_seamwright"));
    Command::new("sh").args(["-c", &line]).current_dir(folder).output().expect("a shell")
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_output_that_is_closed_is_code_4_and_leaves_nothing() {
    let folder = folder();
    let folder = folder.path();
    for args in ["unwrap good.obj -o out.obj --json -", "unwrap good.obj -o -"] {
        let output = shell(folder, "", args, ">&-");
        assert_eq!(output.status.code(), Some(4), "{args}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(!folder.join("out.obj").exists());
        let output = shell(folder, "", args, ">/dev/null");
        assert_eq!(output.status.code(), Some(0), "{args}: {}", String::from_utf8_lossy(&output.stderr));
        let _ = fs::remove_file(folder.join("out.obj"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn too_little_memory_is_code_5() {
    let folder = folder();
    let input = fixture("cube.obj").display().to_string();
    let mut codes = Vec::new();
    for kilobytes in (20_000..400_000).step_by(20_000) {
        let args = format!("unwrap '{input}' -o out.obj -q --threads 2");
        let output = shell(folder.path(), &format!("ulimit -v {kilobytes};"), &args, "");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        let code = output.status.code();
        // So little that the system cannot start a program at all is the system's to tell.
        let is_unborn =
            code == Some(127) || ["loading shared", "fatal runtime"].iter().any(|text| message.contains(text));
        assert!(matches!(code, Some(0 | 5)) || is_unborn, "{kilobytes} kB: {code:?} {message}");
        codes.push(code);
    }
    assert!(codes.contains(&Some(5)) && codes.last() == Some(&Some(0)), "{codes:?}");
}
