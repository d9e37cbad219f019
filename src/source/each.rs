//! Planes one after the other, whichever way they are had.

use std::ops::ControlFlow;

use ndarray::{ArrayView3, ArrayViewMut2, Axis};

use super::{OrderedPlanes, Planes, PositionedPlanes, SourceError, buffer};
use crate::cancel::Cancel;
use crate::geom::Dims;
use crate::volume::{Note, Sample};

/// The planes by the two ways there are; those in memory can be had in any order.
pub(crate) enum Either<'a, T> {
    Ordered(Box<dyn OrderedPlanes<T> + 'a>),
    Positioned(Box<dyn PositionedPlanes<T> + 'a>),
}

impl<'a, T: Sample> From<Planes<'a, T>> for Either<'a, T> {
    fn from(planes: Planes<'a, T>) -> Self {
        match planes {
            Planes::Ordered(inner) => Self::Ordered(inner),
            Planes::Positioned(inner) => Self::Positioned(inner),
            Planes::Resident(array) => Self::Positioned(Box::new(Copied(array))),
        }
    }
}

/// Planes in memory, of any strides, copied out one by one.
pub(crate) struct Copied<'a, T>(pub(crate) ArrayView3<'a, T>);

impl<T: Sample> PositionedPlanes<T> for Copied<'_, T> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        if k >= self.0.len_of(Axis(0)) || out.shape() != &self.0.shape()[1..] {
            return Err(SourceError::PlaneBuffer);
        }
        out.assign(&self.0.index_axis(Axis(0), k));
        Ok(())
    }
}

/// Hands the samples of each plane to `f`, until it has seen enough; gives what was noticed at the
/// end of a stream that was read so far. Holds one plane.
pub(super) fn each_plane<T: Sample>(
    planes: Planes<'_, T>,
    dims: Dims,
    cancel: &Cancel,
    mut f: impl FnMut(&[T]) -> ControlFlow<()>,
) -> Result<Vec<Note>, SourceError> {
    let mut samples = buffer::<T>(dims.plane_len())?;
    let mut planes = Either::from(planes);
    for k in 0..dims.nz() {
        if cancel.is_raised() {
            return Err(SourceError::Interrupted);
        }
        let out = ArrayViewMut2::from_shape((dims.ny(), dims.nx()), &mut samples[..])
            .map_err(|_| SourceError::PlaneBuffer)?;
        match &mut planes {
            Either::Ordered(inner) => inner.next_plane(out)?,
            Either::Positioned(inner) => inner.read_plane(k, out)?,
        }
        if f(&samples).is_break() {
            return Ok(Vec::new());
        }
    }
    match planes {
        Either::Ordered(mut inner) => inner.finish(),
        Either::Positioned(_) => Ok(Vec::new()),
    }
}
