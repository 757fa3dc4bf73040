//! Work that is counted, so that a stage which had to end early can be made to end there again.
//!
//! A stage passes marks, between which it does so much work. At each it may be told to end, by a limit of work or by the caller; where
//! the caller's [alarm](super::scratch::Scratch::with_alarm) broke off what came after a mark, it ends as it stood there. Either way
//! [`Pace::work`] is the limit that ends another run in the same state. No clock is asked.

use super::progress::{Progress, Stage, Wish};
use super::scratch::ScratchTooSmall;

/// Why a stage does not go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// The caller wants nothing any more.
    Stop,
    /// The stage ends with what there is at this mark.
    Here,
    /// The stage ends with what there was at the last mark.
    Back,
}

/// Why work between marks was not done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StageError {
    /// More memory is needed, or the alarm broke it off ([`ScratchTooSmall::ALARM`]).
    Scratch(ScratchTooSmall),
    /// It was told to end.
    Halted(Halt),
}

impl StageError {
    /// Where the stage stands that was told to end ([`Halt::Here`], [`Halt::Back`]); the error itself, if that is not why.
    pub fn end(self, marks: &mut dyn Marks) -> Result<Halt, Self> {
        let halt = match self {
            StageError::Halted(halt) => halt,
            StageError::Scratch(e) if e.is_alarm() => marks.broken(),
            StageError::Scratch(_) => Halt::Stop,
        };
        if halt == Halt::Stop { Err(self) } else { Ok(halt) }
    }
}

impl From<ScratchTooSmall> for StageError {
    fn from(e: ScratchTooSmall) -> Self {
        StageError::Scratch(e)
    }
}

impl From<Halt> for StageError {
    fn from(halt: Halt) -> Self {
        StageError::Halted(halt)
    }
}

/// What passes marks.
pub trait Marks {
    /// A mark: `work` has been done since the last.
    fn mark(&mut self, work: usize) -> Result<(), Halt>;

    /// The alarm has broken off what was under way: why.
    fn broken(&mut self) -> Halt;
}

/// Nothing where `result` is that the stage was told to end, for what is no error then.
pub fn unless_ended<T>(result: Result<T, StageError>, marks: &mut dyn Marks) -> Result<Option<T>, StageError> {
    result.map(Some).or_else(|e| e.end(marks).map(|_| None))
}

/// Of a task that is broken off as a whole.
pub struct NoMarks;

impl Marks for NoMarks {
    fn mark(&mut self, _: usize) -> Result<(), Halt> {
        Ok(())
    }

    fn broken(&mut self) -> Halt {
        Halt::Stop
    }
}

/// Counts the work of one stage.
pub struct Pace<'p> {
    progress: &'p mut dyn Progress,
    stage: Stage,
    place: [usize; 2],
    limit: u64,
    work: Option<u64>, // nothing before the first mark
    ended: bool,
}

impl<'p> Pace<'p> {
    /// A stage that does `limit` work at the most.
    pub fn new(progress: &'p mut dyn Progress, stage: Stage, limit: u64) -> Self {
        Self { progress, stage, place: [0, 1], limit, work: None, ended: false }
    }

    /// `done` of `total` steps are finished, for people.
    pub fn at(&mut self, done: usize, total: usize) {
        self.place = [done, total];
    }

    /// Work done up to the mark whose state counts.
    pub fn work(&self) -> u64 {
        self.work.unwrap_or(0)
    }

    /// Whether the stage was told to end.
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    fn wish(&mut self) -> Wish {
        self.progress.report(self.stage, self.place[0], self.place[1])
    }
}

impl Marks for Pace<'_> {
    fn mark(&mut self, work: usize) -> Result<(), Halt> {
        if self.ended {
            return Err(Halt::Here);
        }
        let wish = self.wish();
        if wish == Wish::Stop {
            return Err(Halt::Stop);
        }
        // Each mark has a number of its own.
        let here = self.work.map_or(0, |before| before.saturating_add(work.max(1) as u64));
        self.work = Some(here);
        self.ended = wish == Wish::Finish || here >= self.limit;
        if self.ended { Err(Halt::Here) } else { Ok(()) }
    }

    fn broken(&mut self) -> Halt {
        self.ended = true;
        if self.wish() == Wish::Finish { Halt::Back } else { Halt::Stop }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers `Finish` from the report of that number on.
    struct Late(usize);

    impl Progress for Late {
        fn report(&mut self, _: Stage, _: usize, _: usize) -> Wish {
            self.0 = self.0.saturating_sub(1);
            if self.0 == 0 { Wish::Finish } else { Wish::GoOn }
        }
    }

    /// Whether each of four marks is passed, and the work of the last that counts.
    fn walk(late: usize, limit: u64) -> ([bool; 4], u64) {
        let mut progress = Late(late);
        let mut pace = Pace::new(&mut progress, Stage::Seams, limit);
        ([5, 5, 0, 7].map(|work| pace.mark(work).is_ok()), pace.work())
    }

    #[test]
    fn the_work_at_which_a_stage_was_told_to_end_is_a_limit_that_ends_at_the_same_mark() {
        assert_eq!(walk(9, u64::MAX), ([true; 4], 13));
        for (late, passed, work) in [(3, [true, true, false, false], 6), (1, [false; 4], 0)] {
            assert_eq!(walk(late, u64::MAX), (passed, work));
            assert_eq!(walk(9, work), (passed, work));
        }
    }

    #[test]
    fn what_was_broken_off_does_not_count() {
        let mut progress = Late(3);
        let mut pace = Pace::new(&mut progress, Stage::Seams, u64::MAX);
        assert_eq!([pace.mark(5), pace.mark(5)], [Ok(()); 2]);
        assert_eq!((pace.broken(), pace.work(), pace.mark(5)), (Halt::Back, 5, Err(Halt::Here)));
    }

    #[test]
    fn an_end_is_told_from_an_error() {
        let alarm = StageError::Scratch(ScratchTooSmall::ALARM);
        let (short, stop) =
            (StageError::Scratch(ScratchTooSmall { need: 2, given: 1 }), StageError::Halted(Halt::Stop));
        let mut progress = Late(1);
        let mut pace = Pace::new(&mut progress, Stage::Seams, u64::MAX);
        assert_eq!([short, stop].map(|e| e.end(&mut pace)), [Err(short), Err(stop)]);
        assert_eq!(StageError::Halted(Halt::Here).end(&mut pace), Ok(Halt::Here));
        assert_eq!((alarm.end(&mut NoMarks), alarm.end(&mut pace)), (Err(alarm), Ok(Halt::Back)));
    }
}
