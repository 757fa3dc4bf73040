//! Memory for several processes: one begins where what it may need is free, or where no other runs.

use std::fs;
use std::sync::{Condvar, Mutex, PoisonError};

/// Memory that is dealt out.
pub(super) struct Admission {
    state: Mutex<State>,
    freed: Condvar,
}

struct State {
    free: u64,
    running: usize,
}

impl Admission {
    /// Deals out `bytes`.
    pub fn new(bytes: u64) -> Self {
        Self { state: Mutex::new(State { free: bytes, running: 0 }), freed: Condvar::new() }
    }

    /// Runs `work` once `need` bytes are free, or nothing else runs.
    pub fn with<T>(&self, need: u64, work: impl FnOnce() -> T) -> T {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let wait = |state: &mut State| state.running > 0 && need > state.free;
        let mut state = self.freed.wait_while(state, wait).unwrap_or_else(PoisonError::into_inner);
        let taken = need.min(state.free);
        state.free -= taken;
        state.running += 1;
        drop(state);
        let result = work();
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.free += taken;
        state.running -= 1;
        self.freed.notify_all();
        result
    }
}

/// Bytes that may be dealt out: nine tenths of what the machine, or the group that the process is in, has left. No bound
/// where neither says.
pub(super) fn available() -> u64 {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
    });
    let groups = [("memory.max", "memory.current"), ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes")];
    let group = groups.iter().find_map(|(most, used)| {
        let at = |name: &str| number(&format!("/sys/fs/cgroup/{name}"));
        Some(at(most)?.saturating_sub(at(used)?))
    });
    machine.into_iter().chain(group).min().map_or(u64::MAX, |bytes| bytes / 10 * 9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

    #[test]
    fn what_does_not_fit_together_runs_one_after_the_other_and_what_never_fits_runs_alone() {
        let (admission, used, most) = (Admission::new(10), AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for need in [4u64, 6, 7, 99, 3, 10, 5] {
                let (admission, used, most) = (&admission, &used, &most);
                scope.spawn(move || {
                    admission.with(need, || {
                        let now = used.fetch_add(need as usize, SeqCst) + need as usize;
                        most.fetch_max(if need == 99 { now - 89 } else { now }, SeqCst);
                        std::thread::sleep(std::time::Duration::from_millis(5));
                        used.fetch_sub(need as usize, SeqCst);
                    });
                });
            }
        });
        assert!(most.into_inner() <= 10 && available() > 1 << 20);
    }
}
