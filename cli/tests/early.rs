//! Runs that end before they are done: by a time limit, by counted work, by a signal.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::{TempDir, tempdir};

/// A folder with a bumpy sheet of 2 `side`^2 triangles.
fn folder(side: usize) -> TempDir {
    let folder = tempdir().expect("a temporary folder");
    let mut obj = String::new();
    for i in 0..(side + 1) * (side + 1) {
        let (x, y) = ((i % (side + 1)) as f64 / side as f64, (i / (side + 1)) as f64 / side as f64);
        writeln!(obj, "v {x} {y} {}", 0.3 * (9.0 * x).sin() * (7.0 * y).cos()).expect("strings grow");
    }
    for i in (0..side * (side + 1)).filter(|i| i % (side + 1) < side).map(|i| i + 1) {
        let up = i + side + 1;
        writeln!(obj, "f {i} {} {}\nf {i} {} {up}", i + 1, up + 1, up + 1).expect("strings grow");
    }
    fs::write(folder.path().join("sheet.obj"), obj).expect("writable");
    folder
}

fn seamwright(folder: &Path, args: &str) -> Output {
    let words = args.split(' ');
    Command::new(env!("CARGO_BIN_EXE_seamwright")).args(words).current_dir(folder).output().expect("the command starts")
}

fn refused(folder: &Path, args: &str, word: &str) {
    let output = seamwright(folder, args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args}: {message}");
    assert!(message.contains(word), "{args}: {message}");
}

#[test]
fn what_a_time_limit_left_is_valid_and_its_work_gives_it_again() {
    let folder = folder(60);
    let folder = folder.path();
    let limited = seamwright(folder, "unwrap sheet.obj -o a.obj --time-limit 0.01 --json a.json");
    let message = String::from_utf8_lossy(&limited.stderr).into_owned();
    assert_eq!(limited.status.code(), Some(0), "{message}");
    assert_eq!(seamwright(folder, "check a.obj --input sheet.obj").status.code(), Some(0));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(folder.join("a.json")).unwrap()).unwrap();
    let work = report["result"]["ended_early"].as_str().expect("a hundredth of a second is not enough");
    assert!(message.contains(&format!("--work {work} ")), "{message}");
    let again = seamwright(folder, &format!("unwrap sheet.obj -o b.obj --work {work} --threads 1 -q"));
    assert_eq!(again.status.code(), Some(0));
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("a.obj") == read("b.obj"));
    // As much time as there is in a day changes nothing.
    seamwright(folder, "unwrap sheet.obj -o c.obj --time-limit 86400 --json c.json -q");
    seamwright(folder, "unwrap sheet.obj -o d.obj -q");
    assert!(read("c.obj") == read("d.obj") && read("c.obj") != read("a.obj"));
    let report: serde_json::Value = serde_json::from_str(&read("c.json")).unwrap();
    assert!(report["result"]["ended_early"].is_null());
}

#[test]
fn limits_that_cannot_be_kept_are_code_2() {
    let folder = folder(2);
    let with = |args: &str, word: &str| refused(folder.path(), &format!("unwrap sheet.obj -o a.obj {args}"), word);
    with("--time-limit 0", "above 0");
    with("--time-limit soon", "not a number");
    with("--work pack", "seams=200000");
    with("--work pack=few", "no count");
    with("--work check=1", "'check'");
    with("--work pack=1 --time-limit 1", "--time-limit");
    with("--method neural --time-limit 1", "--method exact");
    with("--method neural --work pack=1", "--method exact");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_run_soon_and_leaves_nothing() {
    use std::thread::sleep;
    use std::time::{Duration, Instant};
    let folder = folder(250);
    for wait in [30, 400, 1500] {
        let args = ["unwrap", "sheet.obj", "-o", "a.obj", "--json", "a.json", "--search", "100", "-q"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
        let mut run = command.args(args).current_dir(folder.path()).spawn().expect("the command starts");
        sleep(Duration::from_millis(wait));
        let since = Instant::now();
        Command::new("kill").args(["-INT", &run.id().to_string()]).status().expect("kill is there");
        assert_eq!(run.wait().expect("it ends").code(), Some(130), "after {wait} ms");
        // A tenth of a second on a machine that has nothing else to do.
        assert!(since.elapsed() < Duration::from_secs(5), "{:?}", since.elapsed());
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
    }
}
