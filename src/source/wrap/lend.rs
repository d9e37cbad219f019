//! What the steps share: buffers that come back, a step from one plane to one plane.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

use ndarray::ArrayViewMut2;

use crate::error::Kind;
use crate::geom::Dims;
use crate::source::each::Either;
use crate::source::{OrderedPlanes, Planes, PositionedPlanes, SourceError, buffer};
use crate::volume::{Note, Sample};

/// A mistake of the program itself.
pub(super) fn internal(message: &str) -> SourceError {
    SourceError::Other {
        kind: Kind::Internal,
        message: format!("internal error: {message}"),
        hint: None,
    }
}

/// The samples of a plane that was lent, i fastest.
pub(super) fn samples<'o, T>(
    out: &'o mut ArrayViewMut2<'_, T>,
    n: usize,
) -> Result<&'o mut [T], SourceError> {
    let samples = out.as_slice_mut().filter(|s| s.len() == n);
    samples.ok_or_else(|| internal("a plane was lent that is not contiguous or not of its size"))
}

/// A slice of `ny` rows as a plane to be filled.
pub(super) fn plane<T>(samples: &mut [T], nx: usize) -> Result<ArrayViewMut2<'_, T>, SourceError> {
    let ny = samples.len() / nx.max(1);
    ArrayViewMut2::from_shape((ny, nx), samples).map_err(|_| internal("a plane of another size"))
}

/// Buffers of one length that are lent and come back.
pub(super) struct Pool<T> {
    len: usize,
    free: Mutex<Vec<Vec<T>>>,
}

impl<T: Sample> Pool<T> {
    pub(super) fn new(len: usize) -> Self {
        Self { len, free: Mutex::default() }
    }

    /// A buffer with anything in it.
    pub(super) fn lend(&self) -> Result<Lent<'_, T>, SourceError> {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let buffer = match free {
            Some(buffer) => buffer,
            None => buffer(self.len)?,
        };
        Ok(Lent { pool: self, buffer })
    }
}

/// A buffer on loan.
pub(super) struct Lent<'p, T> {
    pool: &'p Pool<T>,
    buffer: Vec<T>,
}

impl<T> Deref for Lent<'_, T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.buffer
    }
}

impl<T> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.buffer
    }
}

impl<T> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        let buffer = std::mem::take(&mut self.buffer);
        self.pool.free.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
    }
}

/// Planes each of which is made from one plane.
struct Mapped<I, T, F> {
    inner: I,
    dims: Dims,
    pool: Pool<T>,
    step: F,
}

/// Turns each plane by `step`, from samples to samples in the same order.
pub(super) fn map_planes<'a, T: Sample, U: Sample>(
    planes: Planes<'a, T>,
    dims: Dims,
    step: impl Fn(&[T], &mut [U]) + Send + Sync + 'a,
) -> Planes<'a, U> {
    let pool = Pool::new(dims.plane_len());
    match planes.into() {
        Either::Ordered(inner) => Planes::Ordered(Box::new(Mapped { inner, dims, pool, step })),
        Either::Positioned(inner) => {
            Planes::Positioned(Box::new(Mapped { inner, dims, pool, step }))
        }
    }
}

impl<T: Sample, U: Sample, F: Fn(&[T], &mut [U]) + Send + Sync> OrderedPlanes<U>
    for Mapped<Box<dyn OrderedPlanes<T> + '_>, T, F>
{
    fn next_plane(&mut self, mut out: ArrayViewMut2<'_, U>) -> Result<(), SourceError> {
        let mut from = self.pool.lend()?;
        self.inner.next_plane(plane(&mut from, self.dims.nx())?)?;
        (self.step)(&from, samples(&mut out, self.dims.plane_len())?);
        Ok(())
    }

    fn finish(&mut self) -> Result<Vec<Note>, SourceError> {
        self.inner.finish()
    }
}

impl<T: Sample, U: Sample, F: Fn(&[T], &mut [U]) + Send + Sync> PositionedPlanes<U>
    for Mapped<Box<dyn PositionedPlanes<T> + '_>, T, F>
{
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, U>) -> Result<(), SourceError> {
        let mut from = self.pool.lend()?;
        self.inner.read_plane(k, plane(&mut from, self.dims.nx())?)?;
        (self.step)(&from, samples(&mut out, self.dims.plane_len())?);
        Ok(())
    }
}
