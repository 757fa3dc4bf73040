//! Cracked meshes through the command: what is told, what is written, and that `check` and `batch` know of it.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Room(tempfile::TempDir);

impl Room {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn command(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_seamwright"));
        command.args(args).current_dir(self.0.path()).output().expect("the command starts")
    }

    fn unwrap(&self, input: &Path, flags: &[&str]) -> (Value, String) {
        let input = input.to_str().expect("a path in UTF-8");
        let output = self.command(&[&["unwrap", input, "-o", "out.obj", "--json", "report.json"], flags].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{flags:?}: {said}");
        let report = fs::read(self.0.path().join("report.json")).expect("a report");
        (serde_json::from_slice(&report).expect("JSON"), said)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.path().join(name)).expect("it was written")
    }
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/faults").join(name)
}

fn vertices(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with("v ")).collect()
}

#[test]
fn a_crack_is_closed_where_that_is_asked_for_and_positions_stay_the_files_own() {
    let (room, input) = (Room::new(), fixture("cracked_sheet.obj"));
    let (report, said) = room.unwrap(&input, &[]);
    assert_eq!((&report["result"]["charts"], &report["settings"]["weld"]), (&2.into(), &"off".into()));
    assert!(!said.contains("cracks closed"), "{said}");
    for width in ["1e-4", "auto"] {
        let (report, said) = room.unwrap(&input, &["--weld", width]);
        assert_eq!(report["result"]["charts"], 1, "{said}");
        assert_eq!(report["result"]["repaired"]["closed_edges"], 3, "{said}");
        assert!(said.contains("cracks closed: 3 edges") && said.contains("border edges 16 -> 10"), "{said}");
        let (before, after) = (fs::read_to_string(&input).expect("a fixture"), room.text("out.obj"));
        assert_eq!(vertices(&before), vertices(&after));
    }
    let (report, said) = room.unwrap(&input, &["--weld", "1e-6"]);
    assert_eq!(report["result"]["charts"], 2, "{said}");
    for (width, code) in [("0", 2), ("0.5", 2), ("wide", 2), ("-1", 2)] {
        let flags = ["unwrap", "a.obj", "-o", "b.obj", &format!("--weld={width}")];
        assert_eq!(room.command(&flags).status.code(), Some(code), "{width}");
    }
}

#[test]
fn a_break_of_the_shading_stays_a_cut_unless_breaks_count_for_nothing() {
    let (room, input) = (Room::new(), fixture("cracked_step.obj"));
    let (report, said) = room.unwrap(&input, &["--weld", "1e-4"]);
    assert_eq!((&report["result"]["charts"], &report["result"]["closed_breaks"]), (&2.into(), &2.into()), "{said}");
    assert!(said.contains("2 stay cut"), "{said}");
    let (report, said) = room.unwrap(&input, &["--weld", "1e-4", "--hard-edges", "off"]);
    assert_eq!((&report["result"]["charts"], &report["result"]["closed_breaks"]), (&1.into(), &0.into()), "{said}");
}

#[test]
fn check_takes_both_sides_of_a_closed_crack_for_one_chart() {
    let (room, input) = (Room::new(), fixture("cracked_sheet.obj"));
    room.unwrap(&input, &["--weld", "auto"]);
    let input = input.to_str().expect("a path in UTF-8");
    let rules = ["check", "out.obj", "--input", input, "--size", "1024", "--padding", "2"];
    let strict = room.command(&rules);
    assert_eq!(strict.status.code(), Some(5), "two charts without a gutter");
    let told = room.command(&[&rules[..], &["--weld", "1e-4"]].concat());
    let said = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.status.success() && said.contains("in 1 chart"), "{said}");
    let narrow = room.command(&[&rules[..], &["--weld", "1e-6"]].concat());
    assert_eq!(narrow.status.code(), Some(5), "the crack is wider");
}

#[test]
fn a_batch_welds_and_knows_that_it_did() {
    let (room, input) = (Room::new(), fixture("cracked_sheet.obj"));
    let input = input.to_str().expect("a path in UTF-8");
    let charts = |flags: &[&str]| {
        let output = room.command(&[&["batch", input, "-o", "made", "--resume"], flags].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let line: Value = serde_json::from_slice(&output.stdout).expect("a line of JSON");
        line["result"]["charts"].clone()
    };
    assert_eq!(charts(&[]), 2);
    assert_eq!(charts(&["--weld", "auto"]), 1, "another setting is another job");
    assert_eq!(charts(&["--weld", "auto"]), 1);
}
