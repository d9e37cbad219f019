//! One pass over a volume's samples: what values there are.

use ndarray::{ArrayViewMut2, Axis};

use super::{Planes, SourceError, Volume};
use crate::cancel::Cancel;
use crate::volume::{Meta, Note, Sample, Survey, Tally};
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
    let [nx, ny, nz] = meta.grid.dims.to_array();
    let mut tally = Tally::<T>::new(meta.padding);
    if let Planes::Resident(array) = &planes {
        for source in array.axis_iter(Axis(0)) {
            go_on(cancel)?;
            match source.as_slice() {
                Some(samples) => tally.add(samples),
                None => source.rows().into_iter().for_each(|row| tally.add(&row.to_vec())),
            }
        }
        return Ok(Survey::new(meta, tally, Vec::new()));
    }
    let mut plane = super::buffer::<T>(nx * ny)?;
    let mut notes: Vec<Note> = Vec::new();
    let mut lend = |fill: &mut dyn FnMut(ArrayViewMut2<'_, T>) -> Result<(), SourceError>| {
        go_on(cancel)?;
        let view = ArrayViewMut2::from_shape((ny, nx), &mut plane[..]);
        fill(view.map_err(|_| SourceError::PlaneBuffer)?)?;
        tally.add(&plane);
        Ok::<(), SourceError>(())
    };
    match planes {
        Planes::Ordered(mut ordered) => {
            for _ in 0..nz {
                lend(&mut |view| ordered.next_plane(view))?;
            }
            notes = ordered.finish()?;
        }
        Planes::Positioned(positioned) => {
            for k in 0..nz {
                lend(&mut |view| positioned.read_plane(k, view))?;
            }
        }
        Planes::Resident(_) => {}
    }
    Ok(Survey::new(meta, tally, notes))
}

pub(super) fn go_on(cancel: &Cancel) -> Result<(), SourceError> {
    if cancel.is_raised() { Err(SourceError::Interrupted) } else { Ok(()) }
}
