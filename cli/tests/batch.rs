//! `batch`: a line a file, whatever the files are; what is done is skipped; a killed run leaves nothing half done.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;
use tempfile::{TempDir, tempdir};

const BAD: [&str; 3] = ["bad_empty.obj", "bad_number.obj", "sub/bad_cut.glb"];

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)
}

/// A folder `in` of ten good meshes, in two folders and four formats, and three bad ones.
fn folder() -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    let path = folder.path().join("in");
    fs::create_dir_all(path.join("sub")).expect("writable");
    let put = |name: &str, bytes: &[u8]| fs::write(path.join(name), bytes).expect("writable");
    for k in 1..=5 {
        let text = format!("v 0 0 0\nv {k} 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
        put(&format!("tetrahedron_{k}.obj"), text.as_bytes());
    }
    for name in ["rigged.glb", "sparse.glb", "one_line.stl", "rows_beyond_header.ply", "stray_header_line.ply"] {
        let bytes = fs::read(fixture("faults").join(name)).expect("a fixture");
        put(&format!("sub/{name}"), &bytes);
    }
    put(BAD[0], b"");
    put(BAD[1], b"v 0 0 0\nv nan 0 0\n");
    put(BAD[2], b"glTF");
    folder
}

fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
    command.args(["batch", "in"]).args(args).current_dir(folder);
    command
}

fn run(folder: &Path, args: &[&str]) -> Output {
    command(folder, args).output().expect("the command starts")
}

/// The lines by their files, without times and memory.
fn lines(output: &Output) -> BTreeMap<String, Value> {
    let text = String::from_utf8(output.stdout.clone()).expect("plain text");
    let line = |line: &str| {
        let mut value: Value = serde_json::from_str(line).expect("a line is JSON");
        let object = value.as_object_mut().expect("an object");
        for key in ["seconds", "memory", "stages"] {
            object.remove(key);
        }
        (value["file"].as_str().expect("a file").to_string(), value)
    };
    text.lines().map(line).collect()
}

/// Every file below, hidden ones too, but for records, which hold times, and what a killed run leaves of one.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let (mut found, mut left) = (BTreeMap::new(), Vec::from_iter(folder.is_dir().then(|| folder.to_path_buf())));
    while let Some(path) = left.pop() {
        for entry in fs::read_dir(&path).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                left.push(path);
            } else if !path.strip_prefix(folder).expect("below").starts_with(".seamwright")
                || path.extension().is_none_or(|e| e != "json" && e != "tmp")
            {
                found.insert(
                    path.strip_prefix(folder).expect("below").to_path_buf(),
                    fs::read(&path).expect("readable"),
                );
            }
        }
    }
    found
}

#[test]
fn bad_files_stop_nothing_and_what_is_done_is_skipped() {
    let folder = folder();
    let folder = folder.path();
    let first = run(folder, &["-o", "out", "--jobs", "3"]);
    let message = String::from_utf8_lossy(&first.stderr).into_owned();
    assert!(first.status.code() == Some(5) && message.contains("3 of 13 files failed"), "{message}");
    let told = lines(&first);
    assert_eq!(told.len(), 13);
    for (file, line) in &told {
        let is_bad = BAD.iter().any(|bad| file.ends_with(bad));
        assert_eq!(
            (line["status"] == "failed", line["code"] == 3, line["output"].is_null()),
            (is_bad, is_bad, is_bad),
            "{line}"
        );
        assert_eq!(
            (line["error"].is_null(), line["result"]["repaired"].is_object(), line["metrics"].is_object()),
            (!is_bad, !is_bad, !is_bad),
            "{line}"
        );
    }
    assert!(told["in/bad_number.obj"]["error"].as_str().is_some_and(|text| text.contains(":2:")));
    let made = files(&folder.join("out"));
    let names: Vec<String> = made.keys().map(|path| path.display().to_string()).collect();
    assert_eq!(
        (names.len(), names.contains(&"sub/one_line.stl.obj".into()), names.contains(&"sub/rigged.glb".into())),
        (10, true, true),
        "{names:?}"
    );

    // Once more: the same lines, and nothing is touched.
    let time =
        |name: &str| fs::metadata(folder.join("out").join(name)).and_then(|data| data.modified()).expect("it is there");
    let before = time("tetrahedron_1.obj");
    let second = run(folder, &["-o", "out", "--resume"]);
    assert_eq!((lines(&second), time("tetrahedron_1.obj")), (told.clone(), before));
    // What has changed, here or there, or is asked for otherwise, is done again.
    fs::write(folder.join("out/tetrahedron_2.obj"), "half").expect("writable");
    fs::write(folder.join("in/tetrahedron_3.obj"), "v 0 0 0\nv 9 0 0\nv 0 1 0\nf 1 2 3\n").expect("writable");
    let third = lines(&run(folder, &["-o", "out", "--resume"]));
    assert_eq!(
        (third["in/tetrahedron_3.obj"]["input"]["polygons"].as_u64(), time("tetrahedron_1.obj")),
        (Some(1), before)
    );
    assert_eq!(files(&folder.join("out"))[Path::new("tetrahedron_2.obj")], made[Path::new("tetrahedron_2.obj")]);
    run(folder, &["-o", "out", "--resume", "--padding", "9"]);
    assert!(time("tetrahedron_1.obj") > before);
    // As one file alone gives it.
    run(folder, &["-o", "out"]);
    let alone = Command::new(env!("CARGO_BIN_EXE_seamwright"))
        .args(["unwrap", "in/sub/rigged.glb", "-o", "alone.glb", "-q"])
        .current_dir(folder)
        .status();
    assert!(alone.is_ok_and(|status| status.success()));
    assert_eq!(
        fs::read(folder.join("alone.glb")).expect("written"),
        files(&folder.join("out"))[Path::new("sub/rigged.glb")]
    );
}

#[test]
fn killed_runs_that_are_resumed_give_what_one_run_gives() {
    let folder = folder();
    let folder = folder.path();
    let whole = lines(&run(folder, &["-o", "whole"]));
    for k in 0..6 {
        let mut child = command(folder, &["-o", "out", "--resume", "--jobs", "2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        sleep(Duration::from_millis(7 + 23 * k));
        child.kill().and_then(|()| child.wait()).expect("it ends");
        // Whatever has its name is whole.
        let wanted = files(&folder.join("whole"));
        for (name, bytes) in files(&folder.join("out")).into_iter().filter(|(name, _)| !name.starts_with(".seamwright"))
        {
            assert!(wanted[&name] == bytes, "{}", name.display());
        }
    }
    let mut resumed = lines(&run(folder, &["-o", "out", "--resume"]));
    for line in resumed.values_mut().filter(|line| line["output"].is_string()) {
        line["output"] = line["output"].as_str().expect("a path").replacen("out", "whole", 1).into();
    }
    assert_eq!((resumed, files(&folder.join("out"))), (whole, files(&folder.join("whole"))));
}

#[test]
fn ranks_share_the_files_and_a_slow_file_is_given_up() {
    let folder = folder();
    let folder = folder.path();
    let ranks: Vec<_> =
        ["0", "1", "2"].iter().map(|rank| run(folder, &["-o", "out", "--rank", rank, "--world-size", "3"])).collect();
    assert_eq!(ranks.iter().map(|output| lines(output).len()).sum::<usize>(), 13);
    assert_eq!(files(&folder.join("out")).len(), 10);

    fs::copy(fixture("knot.obj"), folder.join("in/knot.obj")).expect("writable");
    let late = lines(&run(folder, &["-o", "late", "--timeout", "0.2", "--jobs", "2", "--charts", "one"]));
    let line = &late["in/knot.obj"];
    assert!(
        line["status"] == "timeout" && line["error"].as_str().is_some_and(|text| text.contains("--timeout 0.2")),
        "{line}"
    );
    assert!(!folder.join("late/knot.obj").exists() && late.len() == 14);
}

#[test]
fn all_files_may_get_another_set_of_uvs() {
    let folder = folder();
    let done = run(folder.path(), &["-o", "out", "--jobs", "2", "--uv-set", "2"]);
    let glb = fs::read(folder.path().join("out/sub/rigged.glb")).expect("an output");
    assert!(glb.windows(10).any(|w| w == b"TEXCOORD_2"), "{}", String::from_utf8_lossy(&done.stderr));
    let input = fs::read(folder.path().join("in/sub/rigged.glb")).expect("an input");
    assert!(!input.windows(10).any(|w| w == b"TEXCOORD_2"));
    let refused = run(folder.path(), &["-o", "out", "--uv-set", "16"]);
    assert_eq!(refused.status.code(), Some(2));
}
