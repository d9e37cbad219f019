//! Who may work when: threads and memory, shared out among scans in the order in which they ask.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::cancel::Cancel;

/// Volumes of at least so many bytes of samples get all threads for themselves: shared out one to a
/// scan they would finish last, alone.
const HUGE_BYTES: u64 = 256 << 20;

/// What one scan needs.
pub(crate) struct Need<'a> {
    /// Bytes of the samples.
    pub(crate) sample_bytes: u64,
    /// Bytes of memory that work takes on a number of threads.
    pub(crate) memory: &'a (dyn Fn(usize) -> u64 + Sync),
}

/// Threads and memory of all scans together.
pub(crate) struct Gate {
    free: Mutex<Free>,
    changed: Condvar,
    threads: usize,
    /// Scans side by side at most.
    jobs: usize,
    memory: u64,
    /// Whether a scan that needs more than all the memory is refused; it works alone otherwise.
    is_strict: bool,
}

struct Free {
    threads: usize,
    memory: u64,
    /// Scans that have neither been given a permit nor passed.
    scans_left: usize,
    next_ticket: u64,
    serving: u64,
}

/// Leave to work, given back when dropped.
pub(crate) struct Permit<'g> {
    gate: &'g Gate,
    pub(crate) threads: usize,
    memory: u64,
}

/// Why no permit was given.
pub(crate) enum Refused {
    Interrupted,
    TooLarge { needed: u64, limit: u64 },
}

impl Gate {
    /// `threads` in all, for `jobs` scans at a time; a limit that was asked for, or a share of what
    /// the machine has free.
    pub(crate) fn new(threads: usize, jobs: usize, asked: Option<u64>, n_scans: usize) -> Self {
        let memory = asked.unwrap_or_else(|| available_memory() / 2);
        let free = Free { threads, memory, scans_left: n_scans, next_ticket: 0, serving: 0 };
        Self {
            free: Mutex::new(free),
            changed: Condvar::new(),
            threads,
            jobs,
            memory,
            is_strict: asked.is_some(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Free> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A scan that asks for nothing is done: failed early, or skipped.
    pub(crate) fn pass(&self) {
        let mut free = self.lock();
        free.scans_left = free.scans_left.saturating_sub(1);
        self.changed.notify_all();
    }

    /// Waits for its turn, and until there is room. A small scan works on its share of the threads
    /// (all, where it is the last), a huge one on all of them.
    pub(crate) fn enter(&self, need: &Need<'_>, cancel: &Cancel) -> Result<Permit<'_>, Refused> {
        let is_huge = need.sample_bytes >= HUGE_BYTES;
        let least = (need.memory)(1);
        if self.is_strict && least > self.memory {
            return Err(Refused::TooLarge { needed: least, limit: self.memory });
        }
        let mut free = self.lock();
        let ticket = free.next_ticket;
        free.next_ticket += 1;
        let granted = loop {
            if cancel.is_raised() {
                break None;
            }
            if free.serving == ticket
                && let Some(granted) = self.grant(&free, need, is_huge)
            {
                break Some(granted);
            }
            let wait = self.changed.wait_timeout(free, Duration::from_millis(100));
            free = wait.unwrap_or_else(PoisonError::into_inner).0;
        };
        // Whoever gives up passes the turn on when it comes; the run is ending for all.
        free.serving = free.serving.max(ticket + 1);
        let Some((threads, memory)) = granted else { return Err(Refused::Interrupted) };
        free.threads -= threads;
        free.memory -= memory;
        free.scans_left = free.scans_left.saturating_sub(1);
        self.changed.notify_all();
        Ok(Permit { gate: self, threads, memory })
    }

    /// Threads and memory, if they are free.
    fn grant(&self, free: &Free, need: &Need<'_>, is_huge: bool) -> Option<(usize, u64)> {
        let share = (self.threads / free.scans_left.clamp(1, self.jobs)).max(1);
        let most = if is_huge { self.threads } else { share };
        if free.threads == 0 || is_huge && free.threads < self.threads {
            return None;
        }
        let threads = most_that_fit(most.min(free.threads), |n| (need.memory)(n) <= self.memory);
        let memory = (need.memory)(threads).min(self.memory);
        (memory <= free.memory).then_some((threads, memory))
    }
}

/// The most threads up to `most` that `fits`, or 1: more threads take more memory, so half of what
/// is left is ruled out by each look.
fn most_that_fit(most: usize, fits: impl Fn(usize) -> bool) -> usize {
    if fits(most) {
        return most;
    }
    let (mut good, mut bad) = (1, most);
    while bad - good > 1 {
        let middle = good + (bad - good) / 2;
        if fits(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        let mut free = self.gate.lock();
        free.threads += self.threads;
        free.memory += self.memory;
        self.gate.changed.notify_all();
    }
}

/// Memory that could be had without swapping, in bytes; 4 GiB where the system does not say.
fn available_memory() -> u64 {
    const FALLBACK: u64 = 4 << 30;
    let Ok(text) = std::fs::read_to_string("/proc/meminfo") else { return FALLBACK };
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kibibytes = line.and_then(|l| l.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kibibytes.map_or(FALLBACK, |n| n.saturating_mul(1024))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(bytes: u64) -> impl Fn(usize) -> u64 {
        move |threads| bytes * threads as u64
    }

    #[test]
    fn many_small_scans_get_a_thread_each_and_the_last_gets_all() {
        let gate = Gate::new(4, 4, Some(1000), 5);
        let memory = small(10);
        let need = Need { sample_bytes: 1, memory: &memory };
        let cancel = Cancel::new();
        let first = gate.enter(&need, &cancel).ok().unwrap();
        assert_eq!(first.threads, 1);
        let rest: Vec<_> = (0..3).map(|_| gate.enter(&need, &cancel).ok().unwrap()).collect();
        drop((first, rest));
        assert_eq!(gate.enter(&need, &cancel).ok().unwrap().threads, 4);
    }

    #[test]
    fn one_scan_at_a_time_gets_all_threads() {
        let gate = Gate::new(4, 1, Some(1000), 500);
        let memory = small(10);
        let need = Need { sample_bytes: 1, memory: &memory };
        assert_eq!(gate.enter(&need, &Cancel::new()).ok().unwrap().threads, 4);
    }

    #[test]
    fn a_huge_scan_gets_all_threads_that_memory_allows() {
        let gate = Gate::new(4, 4, Some(30), 9);
        let memory = small(10);
        let cancel = Cancel::new();
        let need = Need { sample_bytes: HUGE_BYTES, memory: &memory };
        assert_eq!(gate.enter(&need, &cancel).ok().unwrap().threads, 3);
    }

    #[test]
    fn the_number_of_threads_is_found_in_few_looks() {
        for most in 1..40_usize {
            for limit in 0..45 {
                let found = most_that_fit(most, |n| n <= limit);
                assert_eq!(found, most.min(limit).max(1), "{most}, {limit}");
            }
        }
        let looks = std::cell::Cell::new(0);
        let fits = |n| {
            looks.set(looks.get() + 1);
            n <= 3
        };
        assert_eq!(most_that_fit(1_000_000_000, fits), 3);
        assert!(looks.get() <= 32, "{looks:?}");
    }

    #[test]
    fn more_than_the_limit_is_refused_and_a_stop_is_heard() {
        let gate = Gate::new(2, 2, Some(30), 9);
        let memory = small(31);
        let cancel = Cancel::new();
        let need = Need { sample_bytes: 1, memory: &memory };
        assert!(matches!(
            gate.enter(&need, &cancel),
            Err(Refused::TooLarge { needed: 31, limit: 30 })
        ));
        let memory = small(20);
        let need = Need { sample_bytes: 1, memory: &memory };
        let _held = gate.enter(&need, &cancel).ok().unwrap();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| gate.enter(&need, &cancel).is_err());
            cancel.raise();
            assert!(waiting.join().unwrap());
        });
    }
}
