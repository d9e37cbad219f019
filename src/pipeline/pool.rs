//! Plane buffers, allocated once and handed round.

use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

use crate::source::{SourceError, buffer};
use crate::volume::Sample;

/// Buffers that are not in use. The last one given back is the first one lent again: it is still
/// in the cache.
#[derive(Debug)]
pub(super) struct Pool<T> {
    plane_len: usize,
    idle: Mutex<Vec<Vec<T>>>,
}

/// The samples of one plane. The buffer goes back to its pool when the last holder lets go.
#[derive(Debug)]
pub(super) struct PlaneBuffer<T> {
    samples: Vec<T>,
    pool: Arc<Pool<T>>,
}

impl<T: Sample> Pool<T> {
    pub(super) fn new(plane_len: usize) -> Arc<Self> {
        Arc::new(Self { plane_len, idle: Mutex::default() })
    }

    /// A buffer of one plane, filled by `fill`; what it held before is garbage.
    ///
    /// # Errors
    /// Those of `fill`, and too little memory.
    pub(super) fn lend<E: From<SourceError>>(
        self: &Arc<Self>,
        fill: impl FnOnce(&mut [T]) -> Result<(), E>,
    ) -> Result<Arc<PlaneBuffer<T>>, E> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut samples = match idle {
            Some(samples) => samples,
            None => buffer(self.plane_len)?,
        };
        fill(&mut samples)?;
        Ok(Arc::new(PlaneBuffer { samples, pool: Arc::clone(self) }))
    }
}

impl<T> Deref for PlaneBuffer<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.samples
    }
}

impl<T> Drop for PlaneBuffer<T> {
    fn drop(&mut self) {
        let samples = std::mem::take(&mut self.samples);
        self.pool.idle.lock().unwrap_or_else(PoisonError::into_inner).push(samples);
    }
}
