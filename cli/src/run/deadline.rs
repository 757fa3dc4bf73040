//! When stages have to end: a clock beside the run, which rings core's alarm.
//!
//! Each stage that can end early may go on until what the stages after it, the check and writing are expected to take is left of the
//! limit: that goes with the mesh's size as what came before the search does (reading, repair, exposure), by whose time it is foreseen.

use core::sync::atomic::{AtomicBool, Ordering};
use seamwright_core::base::progress::Stage;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// What is left of the limit when a stage ends: so many times what came before the search, and a share of the limit at the least and at the most.
const LEFT: [(Stage, f64, [f64; 2]); 3] =
    [(Stage::Exposure, 0.0, [0.75, 0.75]), (Stage::Seams, 2.0, [0.25, 0.5]), (Stage::Pack, 1.0, [0.1, 0.25])];

/// Rings when the time of the stage at work is up.
pub struct Deadlines {
    start: Instant,
    limit: Duration,
    alarm: &'static AtomicBool,
    is_wanted: fn() -> bool,
    clock: Arc<(Mutex<Option<Instant>>, Condvar)>,
    due: Option<Instant>,
    before: Option<Duration>, // from the start to the search
}

impl Deadlines {
    /// A run that began at `start` and should end after `limit`. What is taken back of the alarm stays where `is_wanted` says so.
    pub fn new(start: Instant, limit: Duration, alarm: &'static AtomicBool, is_wanted: fn() -> bool) -> Self {
        let clock = Arc::new((Mutex::new(None), Condvar::new()));
        let hands = Arc::clone(&clock);
        thread::spawn(move || tick(&hands, alarm));
        Self { start, limit, alarm, is_wanted, clock, due: None, before: None }
    }

    /// `stage` begins.
    pub fn enter(&mut self, stage: Stage) {
        if stage == Stage::Seams {
            self.before.get_or_insert(self.start.elapsed());
        }
        let left = LEFT.iter().find(|(s, ..)| *s == stage).map(|(_, times, [least, most])| {
            let before = self.before.unwrap_or(self.limit).mul_f64(*times);
            before.max(self.limit.mul_f64(*least)).min(self.limit.mul_f64(*most))
        });
        self.set(left.map(|left| self.start + (self.limit - left)));
    }

    /// The stage is over.
    pub fn leave(&mut self) {
        self.set(None);
    }

    /// Whether the stage's time is up; the alarm is taken back then.
    pub fn is_up(&mut self) -> bool {
        let is_up = self.due.is_some_and(|due| Instant::now() >= due);
        if is_up {
            // `due` stays: the rest of the stage hears the same.
            self.wind(None);
        }
        is_up
    }

    fn set(&mut self, due: Option<Instant>) {
        self.due = due;
        self.wind(due);
    }

    /// Sets the clock to ring at `due`, or not; from here on it is silent.
    fn wind(&self, due: Option<Instant>) {
        let (next, changed) = &*self.clock;
        // Within the lock, so that the clock cannot ring for what it was set to before.
        let mut next = next.lock().unwrap_or_else(PoisonError::into_inner);
        *next = due;
        self.alarm.store((self.is_wanted)(), Ordering::Relaxed);
        changed.notify_all();
    }
}

/// Rings at whatever time is set, until the program ends.
fn tick(clock: &(Mutex<Option<Instant>>, Condvar), alarm: &AtomicBool) {
    let (next, changed) = clock;
    let mut due = next.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        let now = Instant::now();
        due = match *due {
            None => changed.wait(due).unwrap_or_else(PoisonError::into_inner),
            Some(time) if time > now => changed.wait_timeout(due, time - now).unwrap_or_else(PoisonError::into_inner).0,
            Some(_) => {
                alarm.store(true, Ordering::Relaxed);
                *due = None;
                due
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static ALARM: AtomicBool = AtomicBool::new(false);

    #[test]
    fn the_alarm_sounds_when_a_stage_is_due_and_is_taken_back() {
        let mut deadlines = Deadlines::new(Instant::now(), Duration::from_millis(200), &ALARM, || false);
        let sounds = || ALARM.load(Ordering::Relaxed);
        deadlines.enter(Stage::Repair);
        assert!(!deadlines.is_up() && !sounds());
        deadlines.enter(Stage::Exposure);
        thread::sleep(Duration::from_millis(90));
        assert!(sounds());
        assert!(deadlines.is_up() && !sounds());
        assert!(deadlines.is_up());
        deadlines.enter(Stage::Check);
        assert!(!deadlines.is_up() && !sounds());
        deadlines.enter(Stage::Seams);
        deadlines.leave();
        thread::sleep(Duration::from_millis(90));
        assert!(!sounds());
    }
}
