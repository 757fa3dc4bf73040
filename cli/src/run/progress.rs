//! Progress for people: a line for each stage that has ended, a bar for the one at work on a terminal, nothing when quiet.
//!
//! Everything goes to standard error, so that standard output holds data alone.

use super::deadline::Deadlines;
use super::stop::{alarm, is_unwanted, shorten, stop_requested, take_stop};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use seamwright_core::base::progress::{Progress, Stage, Wish};
use std::io::{IsTerminal, Write, stderr};
use std::time::{Duration, Instant};

/// How the run is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// A line for each finished stage, and a bar that is redrawn.
    Bar,
    /// A line for each finished stage.
    Lines,
    /// Nothing.
    Nothing,
}

impl Show {
    /// What suits standard error.
    pub fn fitting(quiet: bool) -> Self {
        match (quiet, stderr().is_terminal()) {
            (true, _) => Show::Nothing,
            (false, true) => Show::Bar,
            (false, false) => Show::Lines,
        }
    }
}

/// Shows reports and keeps the time of each stage.
pub struct Reporter {
    show: Show,
    bar: ProgressBar,
    current: Option<(Stage, Instant)>,
    times: Vec<StageTime>,
    note: String,
    deadlines: Option<Deadlines>,
}

/// How long a stage took, all its visits together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: &'static str,
    /// Wall time.
    pub time: Duration,
    /// How often the run came to it.
    pub visits: u32,
}

impl Reporter {
    /// Shows nothing before the first report.
    pub fn new(show: Show) -> Self {
        let target = if show == Show::Bar { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        if let Ok(style) = ProgressStyle::with_template("{prefix:9} [{bar:32}] {percent:>3} %  {elapsed} {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { show, bar, current: None, times: Vec::new(), note: String::new(), deadlines: None }
    }

    /// Stages end so that the run, which began at `start`, may end after `limit`.
    pub fn limit(&mut self, start: Instant, limit: Duration) {
        self.deadlines = Some(Deadlines::new(start, limit, alarm(), is_unwanted));
    }

    /// Ends the last stage and gives the times, in the order of each stage's first report.
    pub fn finish(&mut self) -> &[StageTime] {
        self.end_stage();
        self.bar.finish_and_clear();
        &self.times
    }

    /// A line for people, not shown when quiet.
    pub fn say(&self, text: &str) {
        if self.show != Show::Nothing {
            // A closed standard error is no reason to fail.
            self.bar.suspend(|| writeln!(stderr(), "{text}").unwrap_or_default());
        }
    }

    fn end_stage(&mut self) {
        let Some((stage, since)) = self.current.take() else { return };
        let (name, time) = (stage.name(), since.elapsed());
        let visit = match self.times.iter_mut().find(|t| t.stage == name) {
            Some(known) => {
                (known.time, known.visits) = (known.time + time, known.visits + 1);
                known.visits
            }
            None => {
                self.times.push(StageTime { stage: name, time, visits: 1 });
                1
            }
        };
        let again = if visit > 1 { format!("round {visit}  ") } else { String::new() };
        self.say(format!("{name:9} {:8.2} s  {again}{}", time.as_secs_f64(), self.note).trim_end());
    }
}

impl Progress for Reporter {
    fn report(&mut self, stage: Stage, done: usize, total: usize) -> Wish {
        if self.current.is_none_or(|(current, _)| current != stage) {
            self.end_stage();
            self.current = Some((stage, Instant::now()));
            self.bar.set_prefix(stage.name());
            self.bar.set_message("");
            self.note.clear();
            // Training ends early with what it has, and the run goes on.
            shorten(stage == Stage::Learn);
            if let Some(deadlines) = &mut self.deadlines {
                deadlines.enter(stage);
            }
        }
        self.bar.set_length(total as u64);
        self.bar.set_position(done as u64);
        // The wish to end training is granted with that.
        if if stage == Stage::Learn { take_stop() } else { stop_requested() } {
            return Wish::Stop;
        }
        let Some(deadlines) = &mut self.deadlines else { return Wish::GoOn };
        if done == total {
            deadlines.leave();
        }
        if deadlines.is_up() { Wish::Finish } else { Wish::GoOn }
    }

    fn note(&mut self, text: core::fmt::Arguments) {
        self.note = text.to_string();
        let left = self.current.filter(|_| self.bar.position() > 0).map_or(String::new(), |(_, since)| {
            let (done, total) = (self.bar.position() as f64, self.bar.length().unwrap_or(0) as f64);
            format!("{:.0} s left, ", since.elapsed().as_secs_f64() / done * (total - done).max(0.0))
        });
        self.bar.set_message(format!("{left}{text}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_comes_back_is_counted_once() {
        let mut reporter = Reporter::new(Show::Nothing);
        for stage in [Stage::Cut, Stage::Flatten, Stage::Cut] {
            assert_eq!(reporter.report(stage, 0, 1), Wish::GoOn);
        }
        let names: Vec<_> = reporter.finish().iter().map(|t| t.stage).collect();
        assert_eq!(names, ["cut", "flatten"]);
    }
}
