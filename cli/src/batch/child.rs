//! A process that unwraps one file, watched: how long it takes, how much memory, how it ends.
//!
//! Its standard input is a pipe from here that nobody writes to. When this process dies, however it does, the pipe closes and
//! the child ends too (see `run::stop`).

use crate::run::stop::{FOLLOWS, stop_requested};
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{self, Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How a child ended.
pub(super) enum End {
    /// With this exit code; `None`: it was killed by something else.
    Code(Option<i32>),
    /// It was given up after the time that it had.
    Late,
    /// The user stopped the batch.
    Stopped,
}

/// What was seen of a child.
pub(super) struct Watched {
    pub end: End,
    pub seconds: f64,
    /// The most memory that it had, in bytes, where the system says it.
    pub memory: Option<u64>,
    /// What it said.
    pub said: String,
}

/// Runs this program with `words`, for `limit` at the most; what it says goes to the file `said`.
pub(super) fn watch(words: &[&std::ffi::OsStr], limit: Option<Duration>, said: &Path) -> io::Result<Watched> {
    let start = Instant::now();
    let mut child = process::Command::new(std::env::current_exe()?)
        .args(words)
        .env(FOLLOWS, "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(File::create(said)?)
        .spawn()?;
    let mut memory = None;
    let end = loop {
        memory = peak(&child).max(memory);
        if let Some(status) = child.try_wait()? {
            break End::Code(status.code());
        }
        let is_late = limit.is_some_and(|limit| start.elapsed() > limit);
        if is_late || stop_requested() {
            child.kill()?;
            child.wait()?;
            break if stop_requested() { End::Stopped } else { End::Late };
        }
        // Short files are not made to wait, long ones are seldom looked at.
        sleep((start.elapsed() / 20).clamp(Duration::from_millis(1), Duration::from_millis(20)));
    };
    let said = String::from_utf8_lossy(&fs::read(said)?).into_owned();
    Ok(Watched { end, seconds: start.elapsed().as_secs_f64(), memory, said })
}

/// The most memory that a process has had so far.
fn peak(child: &Child) -> Option<u64> {
    let text = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
