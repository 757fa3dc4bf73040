//! The caller's functions as core's workers and progress.
//!
//! `unsafe` lives here: a task crosses the border as a pointer to a reference, and comes back within the same call.

use crate::types::{SEAMWRIGHT_FINISH, SEAMWRIGHT_GO_ON, SeamwrightHost};
use core::ffi::{CStr, c_void};
use core::ptr;
use seamwright_core::base::progress::{Progress, Stage, Wish};
use seamwright_core::base::workers::{Serial, Workers};

/// What the caller offers, or nothing.
pub struct Host(SeamwrightHost);

impl Host {
    /// Offers nothing.
    pub fn none() -> Self {
        Self(SeamwrightHost::INIT)
    }

    pub fn new(offer: SeamwrightHost) -> Self {
        Self(offer)
    }
}

// SAFETY: `user` is only handed back to the caller's functions; that `run` may be called on any thread is its contract.
unsafe impl Sync for Host {}

type Task<'a> = &'a (dyn Fn(usize) + Sync);

extern "C" fn call(context: *mut c_void, index: usize) {
    // SAFETY: `run` below made it from a task that lives until all calls are done.
    let task = unsafe { *context.cast::<Task>() };
    task(index);
}

impl Workers for Host {
    fn run(&self, count: usize, task: &(dyn Fn(usize) + Sync)) {
        match self.0.run {
            Some(run) if count > 1 => run(self.0.user, count, call, ptr::from_ref(&task).cast_mut().cast()),
            _ => Serial.run(count, task),
        }
    }
}

/// The half that is told of progress: on the calling thread alone.
pub struct Listener<'a> {
    pub host: &'a Host,
    /// Whether it may end stages early.
    pub may_finish: bool,
}

impl Progress for Listener<'_> {
    fn report(&mut self, stage: Stage, done: usize, total: usize) -> Wish {
        let SeamwrightHost { user, progress, .. } = self.host.0;
        match progress.map_or(0, |tell| tell(user, name(stage).as_ptr(), done, total)) {
            SEAMWRIGHT_GO_ON => Wish::GoOn,
            SEAMWRIGHT_FINISH if self.may_finish => Wish::Finish,
            _ => Wish::Stop,
        }
    }
}

fn name(stage: Stage) -> &'static CStr {
    match stage {
        Stage::Repair => c"repair",
        Stage::Parts => c"parts",
        Stage::Exposure => c"exposure",
        Stage::Learn => c"learn",
        Stage::Cut => c"cut",
        Stage::Flatten => c"flatten",
        Stage::Seams => c"seams",
        Stage::Pack => c"pack",
        Stage::Check => c"check",
    }
}
