//! Planes made by several threads, handed on in order. Holds two planes a thread, whatever their
//! number.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use ndarray::Array2;

use super::PhantomError;
use crate::cancel::Cancel;
use crate::geom::Dims;
use crate::source::{PositionedPlanes, SourceError};
use crate::volume::Sample;

/// A plane that a thread made, or why it could not.
type Made<T> = Result<Array2<T>, SourceError>;

/// Makes all planes on `threads - 1` threads and gives them to `take` on this one; with one thread
/// all is done here.
pub(super) fn in_order<T: Sample>(
    planes: &dyn PositionedPlanes<T>,
    dims: Dims,
    threads: usize,
    cancel: &Cancel,
    mut take: impl FnMut(&Array2<T>) -> Result<(), PhantomError>,
) -> Result<(), PhantomError> {
    let buffer = || Array2::<T>::default((dims.ny(), dims.nx()));
    let n_makers = threads.saturating_sub(1).min(dims.nz());
    if n_makers == 0 {
        let mut plane = buffer();
        for k in 0..dims.nz() {
            stop(cancel)?;
            planes.read_plane(k, plane.view_mut())?;
            take(&plane)?;
        }
        return Ok(());
    }
    thread::scope(|scope| {
        let mut makers = Vec::with_capacity(n_makers);
        let mut threads = Vec::with_capacity(n_makers);
        for maker in 0..n_makers {
            let (send_made, made) = sync_channel::<Made<T>>(2);
            let (send_back, back) = sync_channel(2);
            for _ in 0..2 {
                // There is room for two.
                let _ = send_back.send(buffer());
            }
            let mine = (maker..dims.nz()).step_by(n_makers);
            let work = move || make(planes, mine, &back, &send_made);
            let thread = thread::Builder::new()
                .spawn_scoped(scope, work)
                .map_err(|e| PhantomError::Source(SourceError::Io(e)))?;
            threads.push(thread);
            makers.push((made, send_back));
        }
        let mut done = Ok(());
        for k in 0..dims.nz() {
            let Some(maker) = makers.get(k % n_makers) else { break };
            done = stop(cancel).and_then(|()| hand_on(maker, &mut take));
            if done.is_err() {
                break;
            }
        }
        // Closes the channels, which ends the threads.
        drop(makers);
        for thread in threads {
            // One that died was told when its plane was missed; not waited for it would end all.
            let _ = thread.join();
        }
        done
    })
}

/// Takes the next plane of one thread, and gives the buffer back.
fn hand_on<T>(
    (made, back): &(Receiver<Made<T>>, SyncSender<Array2<T>>),
    take: &mut impl FnMut(&Array2<T>) -> Result<(), PhantomError>,
) -> Result<(), PhantomError> {
    let died = PhantomError::Internal("a thread that makes planes ended before its time");
    let plane = made.recv().map_err(|_| died)??;
    take(&plane)?;
    // A thread that has made its last plane wants none back.
    let _ = back.send(plane);
    Ok(())
}

/// Makes planes in the buffers that come back, until nobody wants them any more.
fn make<T: Sample>(
    planes: &dyn PositionedPlanes<T>,
    mine: impl Iterator<Item = usize>,
    back: &Receiver<Array2<T>>,
    made: &SyncSender<Made<T>>,
) {
    for k in mine {
        let Ok(mut plane) = back.recv() else { return };
        let result = planes.read_plane(k, plane.view_mut()).map(|()| plane);
        let failed = result.is_err();
        if made.send(result).is_err() || failed {
            return;
        }
    }
}

fn stop(cancel: &Cancel) -> Result<(), PhantomError> {
    if cancel.is_raised() { Err(PhantomError::Interrupted) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use ndarray::ArrayViewMut2;

    use super::*;

    /// Planes of which one is the end of the thread that makes it.
    struct Deadly;

    impl PositionedPlanes<u8> for Deadly {
        fn read_plane(&self, k: usize, _: ArrayViewMut2<'_, u8>) -> Result<(), SourceError> {
            assert!(k != 5, "meant to end this thread");
            Ok(())
        }
    }

    #[test]
    fn a_thread_that_died_is_told_as_such() {
        let dims = Dims::checked(2, 2, 9, 1).unwrap();
        let told = in_order(&Deadly, dims, 3, &Cancel::new(), |_| Ok(()));
        let said = told.unwrap_err().to_string();
        assert_eq!(said, "internal error: a thread that makes planes ended before its time");
    }
}
