//! One pass over a volume's samples: what values there are.

use std::ops::ControlFlow;

use super::each::each_plane;
use super::{Planes, SourceError, Volume};
use crate::cancel::Cancel;
use crate::volume::{Meta, Sample, Survey, Tally};
use crate::with_planes;

/// Reads every sample once and says what values there are. Holds one plane, and half a megabyte of
/// counts.
///
/// # Errors
/// Whatever the planes have to say; too little memory for one plane; [`SourceError::Interrupted`].
pub fn survey(volume: Volume<'_>, cancel: &Cancel) -> Result<Survey, SourceError> {
    let Volume { meta, planes } = volume;
    with_planes!(planes, planes => of(&meta, planes, cancel))
}

fn of<T: Sample>(
    meta: &Meta,
    planes: Planes<'_, T>,
    cancel: &Cancel,
) -> Result<Survey, SourceError> {
    let mut tally = Tally::<T>::new(meta.padding);
    let notes = each_plane(planes, meta.grid.dims, cancel, |samples| {
        tally.add(samples);
        ControlFlow::Continue(())
    })?;
    Ok(Survey::new(meta, tally, notes))
}
