//! What workers do one after another, in slab order: numbering vertices, appending patches.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::RunError;

/// A state that slab after slab has its turn with.
#[derive(Debug)]
pub(super) struct Sequence<S> {
    turn: Mutex<(usize, S)>,
    changed: Condvar,
}

impl<S> Sequence<S> {
    pub(super) fn new(state: S) -> Self {
        Self { turn: Mutex::new((0, state)), changed: Condvar::new() }
    }

    /// Waits until the slabs before `slab` have had their turn, then runs `f` and passes the turn
    /// on. Gives nothing where the run was stopped by someone else.
    pub(super) fn in_turn<R>(
        &self,
        stop: &Stop,
        slab: usize,
        f: impl FnOnce(&mut S) -> Result<R, RunError>,
    ) -> Result<Option<R>, RunError> {
        let mut turn = lock(&self.turn);
        while turn.0 != slab {
            if stop.is_raised() {
                return Ok(None);
            }
            turn = self.changed.wait(turn).unwrap_or_else(PoisonError::into_inner);
        }
        let result = f(&mut turn.1)?;
        turn.0 += 1;
        self.changed.notify_all();
        Ok(Some(result))
    }

    /// Wakes whoever waits, to see that the run was stopped.
    pub(super) fn wake(&self) {
        let _turn = lock(&self.turn);
        self.changed.notify_all();
    }

    pub(super) fn into_inner(self) -> S {
        self.turn.into_inner().unwrap_or_else(PoisonError::into_inner).1
    }
}

/// Whether the run is to stop, and the error of the lowest slab that had one.
#[derive(Debug, Default)]
pub(super) struct Stop {
    raised: AtomicBool,
    first: Mutex<Option<(usize, RunError)>>,
}

impl Stop {
    pub(super) fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// Notes an error. The caller then wakes all sequences.
    pub(super) fn raise(&self, slab: usize, error: RunError) {
        let mut first = lock(&self.first);
        if first.as_ref().is_none_or(|(earlier, _)| slab < *earlier) {
            *first = Some((slab, error));
        }
        self.raised.store(true, Ordering::Relaxed);
    }

    pub(super) fn into_result(self) -> Result<(), RunError> {
        match self.first.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
