//! A batch: its files by several processes at once, a line of JSON for each as it ends.

use super::admission::{Admission, available};
use super::child::{End, Watched, watch};
use super::digest::of_job;
use super::items::Item;
use super::place::place;
use super::record::{HIDDEN, JobRecord};
use crate::args::batch::BatchArgs;
use crate::base::failure::Failure;
use crate::formats::format::Format;
use crate::formats::loaded::{Loaded, load_as};
use crate::formats::reading::Reading;
use crate::run::atlas;
use crate::run::stop::stop_requested;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::{Write, stderr, stdout};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{available_parallelism, sleep};
use std::time::Duration;
use tempfile::TempDir;

/// Bytes that a process takes for itself, and for each byte of its file.
const BASE: u64 = 32 << 20;
const PER_BYTE: u64 = 10;

/// What is the same for all files.
struct Batch<'a> {
    args: &'a BatchArgs,
    /// The flags that settings become.
    words: Vec<String>,
    threads: String,
    /// Where outputs are made.
    staging: TempDir,
    admission: Admission,
    /// Held while a line is printed; whether printing has failed.
    out: Mutex<Option<Failure>>,
    failed: AtomicUsize,
}

/// Unwraps all `items`. The failure is that some could not be, that lines cannot be printed, or that the user stopped it.
pub fn run(args: &BatchArgs, items: &[Item]) -> Result<(), Failure> {
    let cores = available_parallelism().map_or(1, usize::from);
    let jobs = args.jobs.map_or(cores, usize::from).min(items.len()).max(1);
    let mut words = args.settings.words();
    words.extend(["--group".into(), args.group.name().into(), "--uv-set".into(), args.set.uv_set.to_string()]);
    let flags = [("--keep", args.set.keep), ("--keep-seams", args.keep_seams)];
    words.extend(flags.iter().filter(|(_, is_set)| *is_set).map(|(flag, _)| flag.to_string()));
    let batch = Batch {
        args,
        words,
        threads: (cores / jobs).max(1).to_string(),
        staging: staging(args).map_err(|e| Failure::output("-o", &args.output, &e))?,
        admission: Admission::new(available()),
        out: Mutex::new(None),
        failed: AtomicUsize::new(0),
    };
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            let line = batch.item(item);
            batch.failed.fetch_add(usize::from(line["status"] != "done"), Ordering::Relaxed);
            if stop_requested() || !batch.print(&line) {
                break;
            }
        }
    };
    std::thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work))));
    if let Some(failure) = batch.out.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(failure);
    }
    if stop_requested() {
        let _ = writeln!(stderr(), "seamwright: what is done stays, --resume goes on from there");
        return Err(Failure::Stopped);
    }
    match batch.failed.into_inner() {
        0 => Ok(()),
        failed => {
            let text =
                format!("{failed} of {} files failed or missed what was asked; their lines say why", items.len());
            Err(Failure::Unreached(text))
        }
    }
}

/// A folder to make outputs in, beside where they go. What a killed run of the same share left is removed.
fn staging(args: &BatchArgs) -> std::io::Result<TempDir> {
    let hidden = args.output.join(HIDDEN);
    fs::create_dir_all(&hidden)?;
    let prefix = format!(".rank-{}-of-{}-", args.rank, args.world_size);
    for entry in fs::read_dir(&hidden)?.flatten() {
        if entry.file_name().to_string_lossy().starts_with(&prefix) {
            // A child of that run may be about to end, and still write there.
            let is_gone = |_: &u32| fs::remove_dir_all(entry.path()).is_ok() || !entry.path().exists();
            let _ = (0..50).find(|k| {
                is_gone(k) || {
                    sleep(Duration::from_millis(10));
                    false
                }
            });
        }
    }
    tempfile::Builder::new().prefix(&prefix).tempdir_in(hidden)
}

impl Batch<'_> {
    /// Does a file, unless that is done. Gives its line.
    fn item(&self, item: &Item) -> Value {
        let folder = &self.args.output;
        let before = JobRecord::left(folder, item);
        let job = match of_job(&item.input, &self.words) {
            Ok(job) => job,
            Err(e) => return self.failure(item, "failed", &Failure::input(&item.input, &e), None),
        };
        if let Some(record) = before.as_ref().filter(|record| self.args.resume && record.holds(folder, &job)) {
            return record.line.clone();
        }
        let reading =
            Reading { copies: !Format::of(&item.name).is_some_and(Format::has_instances), ..Reading::default() };
        let loaded = match load_as(&item.input, reading).and_then(|l| l.polygons().map(drop).map(|()| l)) {
            Ok(loaded) => loaded,
            Err(failure) => return self.failure(item, "failed", &failure, None),
        };
        let need = self.need(&loaded, &item.input);
        drop(loaded);
        self.admission.with(need, || self.unwrap(item, &job, before.as_ref()))
    }

    /// Memory that a file may need.
    fn need(&self, loaded: &Loaded, input: &Path) -> u64 {
        let file = fs::metadata(input).map_or(0, |data| data.len());
        let core = atlas::need(loaded.mesh(), &self.args.settings.to_core()) as u64;
        core.saturating_add(BASE).saturating_add(file.saturating_mul(PER_BYTE))
    }

    fn unwrap(&self, item: &Item, job: &str, before: Option<&JobRecord>) -> Value {
        if stop_requested() {
            return self.failure(item, "failed", &Failure::Stopped, None);
        }
        let made = || -> Result<(TempDir, PathBuf, Watched), std::io::Error> {
            let room = tempfile::tempdir_in(self.staging.path())?;
            let output = room.path().join("made").join(&item.name);
            output.parent().map_or(Ok(()), fs::create_dir_all)?;
            let report = room.path().join("report.json");
            let words = self.words.iter().map(OsStr::new);
            let fixed = ["unwrap", "--quiet", "--threads", &self.threads].map(OsStr::new).into_iter();
            let paths =
                [OsStr::new("-o"), output.as_os_str(), OsStr::new("--json"), report.as_os_str(), OsStr::new("--")];
            let words: Vec<&OsStr> = fixed.chain(words).chain(paths).chain([item.input.as_os_str()]).collect();
            let limit = self.args.timeout.map(Duration::from_secs_f64);
            let watched = watch(&words, limit, &room.path().join("said"))?;
            Ok((room, report, watched))
        };
        let (room, report, watched) = match made() {
            Ok(made) => made,
            Err(e) => return self.failure(item, "failed", &Failure::output("-o", &self.args.output, &e), None),
        };
        let code = match &watched.end {
            End::Code(Some(code)) => *code,
            End::Code(None) => {
                let text = format!(
                    "{}: its process was ended from outside; there may be too little memory",
                    item.input.display()
                );
                return self.failure(item, "failed", &Failure::Unreached(text), Some(&watched));
            }
            End::Late => {
                let seconds = self.args.timeout.unwrap_or(0.0);
                let text = format!("{}: given up after --timeout {seconds}", item.input.display());
                return self.failure(item, "timeout", &Failure::Unreached(text), Some(&watched));
            }
            End::Stopped => return self.failure(item, "failed", &Failure::Stopped, Some(&watched)),
        };
        let folder = room.path().join("made").display().to_string();
        let said = watched
            .said
            .trim()
            .trim_start_matches("seamwright: ")
            .replace(&folder, &self.args.output.display().to_string());
        let report = fs::read(report).ok().and_then(|text| serde_json::from_slice::<Map<String, Value>>(&text).ok());
        // Without a result the report says why there is none; a missed bound is code 5 with a result.
        let Some(report) = report.filter(|report| report.contains_key("result")) else {
            let mut line = self.line(item, "failed", Some(code), Some(said), Some(&watched));
            line["output"] = Value::Null;
            return line;
        };
        let outputs = match place(&room.path().join("made"), &self.args.output, &item.name, before) {
            Ok(outputs) => outputs,
            Err(failure) => return self.failure(item, "failed", &failure, Some(&watched)),
        };
        let mut line = self.line(
            item,
            if code == 0 { "done" } else { "missed" },
            Some(code),
            Some(said).filter(|_| code != 0),
            Some(&watched),
        );
        for (key, mut value) in report {
            match key.as_str() {
                "version" | "settings" | "output" | "seconds" => continue,
                "metrics" => forget_path(&mut value),
                "atlases" => {
                    let all = value.as_array_mut().into_iter().flatten();
                    all.filter_map(|atlas| atlas.get_mut("metrics")).for_each(forget_path);
                }
                _ => {}
            }
            line[&key] = value;
        }
        if let Err(failure) = self.keep(item, job, outputs, &line) {
            return self.failure(item, "failed", &failure, Some(&watched));
        }
        line
    }

    fn keep(&self, item: &Item, job: &str, outputs: BTreeMap<String, String>, line: &Value) -> Result<(), Failure> {
        let record = JobRecord { job: job.into(), outputs, line: line.clone() };
        let path = JobRecord::path(&self.args.output, item);
        // Made where the next run of this share sweeps, should this one be killed.
        let write = || {
            let room = tempfile::tempdir_in(self.staging.path())?;
            let draft = room.path().join("record");
            let mut file = fs::File::create(&draft)?;
            serde_json::to_writer(&mut file, &record)?;
            file.sync_all()?;
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            fs::rename(&draft, &path)
        };
        write().map_err(|e| Failure::output("-o", &path, &e))
    }

    fn failure(&self, item: &Item, status: &str, failure: &Failure, watched: Option<&Watched>) -> Value {
        let mut line = self.line(item, status, Some(failure.code().into()), Some(failure.to_string()), watched);
        line["output"] = Value::Null;
        line
    }

    fn line(
        &self,
        item: &Item,
        status: &str,
        code: Option<i32>,
        error: Option<String>,
        watched: Option<&Watched>,
    ) -> Value {
        json!({
            "file": item.input.display().to_string(),
            "output": self.args.output.join(&item.name).display().to_string(),
            "status": status,
            "code": code,
            "error": error,
            "seconds": watched.map(|watched| watched.seconds),
            "memory": watched.and_then(|watched| watched.memory),
        })
    }

    /// Prints a line. False where nobody can read it.
    fn print(&self, line: &Value) -> bool {
        let mut failed = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        if failed.is_some() {
            return false;
        }
        let mut out = stdout().lock();
        match writeln!(out, "{line}").and_then(|()| out.flush()) {
            Ok(()) => true,
            Err(e) => {
                *failed = Some(Failure::output("standard output", Path::new("-"), &e));
                false
            }
        }
    }
}

/// Takes the path out of figures: it is where the atlas was made, and another one each time.
fn forget_path(metrics: &mut Value) {
    metrics.as_object_mut().map(|metrics| metrics.shift_remove("obj"));
}
