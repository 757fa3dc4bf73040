//! What jobs and commands share of their outputs: none falls on another, all appear together, the report last.

use crate::base::failure::Failure;
use crate::files::drafts::Drafts;
use crate::files::paths::{is_stdout, same_file};
use crate::formats::target::{Files, Target};
use crate::report::document::write_json;
use crate::report::failed::FailureReport;
use crate::run::stop::stop_requested;
use serde::Serialize;
use std::io::stdout;
use std::path::{Path, PathBuf};

/// A flag with its path, and what that path may not be: its name and place.
pub type Clash<'c> = (&'c str, Option<&'c Path>, &'c str, Option<&'c Path>);

/// Refuses a path that is the same file as another.
pub fn refuse_clashes(clashes: &[Clash]) -> Result<(), Failure> {
    for (flag, path, other, place) in clashes {
        if let (Some(path), Some(place)) = (path, place)
            && same_file(path, place)
        {
            let text = format!("{flag} {}: the same file as {other}; choose another", path.display());
            return Err(Failure::Usage(text));
        }
    }
    Ok(())
}

/// Refuses outputs that fall on what was read: the files that a mesh names, or what else has a flag.
pub fn refuse_over_inputs(outputs: &[(&str, Option<&Path>)], inputs: &[(&str, PathBuf)]) -> Result<(), Failure> {
    for (what, input) in inputs {
        let clashes: Vec<Clash> =
            outputs.iter().map(|(flag, path)| (*flag, *path, *what, Some(input.as_path()))).collect();
        refuse_clashes(&clashes)?;
    }
    Ok(())
}

/// Refuses a mesh and a report that would both go to standard output.
pub fn refuse_two_streams(target: &Target, json: Option<&Path>) -> Result<(), Failure> {
    if json.is_some_and(is_stdout) && target.is_stream() {
        return Err(Failure::Usage("--json -: standard output takes the mesh already; name a file".into()));
    }
    Ok(())
}

/// Adds the files of a mesh.
pub fn add_mesh(drafts: &mut Drafts, target: &Target, files: Files) -> Result<(), Failure> {
    if let Some((path, _)) = files.beside.first().filter(|_| target.is_stream()) {
        let text = format!("it needs {} beside it; name a file, or take --format glb", path.display());
        return Err(Failure::Usage(format!("-o -: {text}")));
    }
    for (path, bytes) in &files.beside {
        drafts.add_below("-o", path, |out| out.write_all(bytes))?;
    }
    drafts.add("-o", &target.path, files.main)
}

/// Puts the outputs in place, the report last.
pub fn publish(mut drafts: Drafts, json: Option<&Path>, report: &impl Serialize) -> Result<(), Failure> {
    match json {
        Some(path) if !is_stdout(path) => drafts.add("--json", path, |out| write_json(report, out))?,
        _ => {}
    }
    if stop_requested() {
        return Err(Failure::Stopped);
    }
    // What can fail comes before what hardly can.
    if let Some(path) = json.filter(|path| is_stdout(path)) {
        write_json(report, &mut stdout().lock()).map_err(|e| Failure::output("--json", path, &e))?;
    }
    drafts.publish()
}

/// Writes to the report at `json` why there is no atlas, where the mesh at `input` is why. What cannot be written is not told of: the
/// code and the message stand for themselves.
pub fn report_failure(json: Option<&Path>, input: &Path, failure: &Failure) {
    let Some(path) = json.filter(|_| matches!(failure, Failure::Input(_) | Failure::Unreached(_))) else {
        return;
    };
    let report = FailureReport::new(input, failure);
    if is_stdout(path) {
        let _ = write_json(&report, &mut stdout().lock());
        return;
    }
    let mut drafts = Drafts::new();
    let _ = drafts.add("--json", path, |out| write_json(&report, out)).and_then(|()| drafts.publish());
}
