//! What jobs and commands share of their outputs: none falls on another, all appear together, the report last.

use crate::base::failure::Failure;
use crate::files::drafts::{self, Drafts};
use crate::files::paths::{is_stdout, same_file};
use crate::formats::loaded::Loaded;
use crate::formats::target::{Files, Target};
use crate::report::document::write_json;
use crate::report::failed::FailureReport;
use crate::run::stop::stop_requested;
use serde::Serialize;
use std::fs;
use std::io::stdout;
use std::path::Path;

/// An output that is asked for: its flag, and its place where it is named.
pub type NamedOutput<'o> = (&'static str, Option<&'o Path>);

/// Refuses outputs that fall on those before them.
pub fn refuse_clashes(outputs: &[NamedOutput]) -> Result<(), Failure> {
    for (i, (flag, path)) in outputs.iter().enumerate() {
        let Some(path) = path else { continue };
        refuse_over(&outputs[i + 1..], flag, path)?;
    }
    Ok(())
}

/// Refuses outputs that fall on `place`, which messages call `what`.
pub fn refuse_over(outputs: &[NamedOutput], what: &str, place: &Path) -> Result<(), Failure> {
    let mut named = outputs.iter().filter_map(|(flag, path)| Some((flag, (*path)?)));
    match named.find(|(_, path)| same_file(path, place)) {
        Some((flag, path)) => {
            Err(Failure::Usage(format!("{flag} {}: the same file as {what}; choose another", path.display())))
        }
        None => Ok(()),
    }
}

/// Refuses outputs that fall on files that a mesh names.
pub fn refuse_over_named(outputs: &[NamedOutput], loaded: &Loaded) -> Result<(), Failure> {
    loaded.beside().iter().try_for_each(|path| refuse_over(outputs, "a file that the mesh names", path))
}

/// Finds out whether all outputs can be written.
pub fn check_writable(outputs: &[NamedOutput]) -> Result<(), Failure> {
    outputs.iter().try_for_each(|(flag, path)| path.map_or(Ok(()), |path| drafts::check(flag, path)))
}

/// Refuses a picture that is no `.png`; what is no regular file has no ending to go by.
pub fn refuse_other_pictures(pictures: &[NamedOutput]) -> Result<(), Failure> {
    let is_other = |path: &Path| {
        let special = fs::metadata(path).is_ok_and(|data| !data.is_file() && !data.is_dir());
        !special && !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
    };
    let mut named = pictures.iter().filter_map(|(flag, path)| Some((flag, (*path)?)));
    match named.find(|(_, path)| is_other(path)) {
        Some((flag, path)) => Err(Failure::Usage(format!("{flag} {}: name a file that ends in .png", path.display()))),
        None => Ok(()),
    }
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
