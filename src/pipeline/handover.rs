//! The bits of planes that two slabs share, handed from worker to worker so that a plane is
//! compared once. A matter of speed alone: what is not there is compared again.

use std::sync::{Mutex, PoisonError};

use crate::kernel::{Scratch, SharedPlane};

/// One place for each worker: no more slabs are under way.
#[derive(Debug)]
pub(super) struct Handover {
    places: Vec<Mutex<(usize, SharedPlane)>>,
}

impl Handover {
    /// For some workers; a lone one keeps its own last plane.
    pub(super) fn new(workers: usize) -> Self {
        let n = if workers > 1 { workers + 1 } else { 0 };
        Self { places: (0..n).map(|_| Mutex::default()).collect() }
    }

    /// Called with the planes of a slab classified: leaves the last for the slab after it, and takes
    /// the first from the slab before it if that one was quicker.
    pub(super) fn exchange(&self, slab: usize, scratch: &mut Scratch) {
        self.at(slab + 1, |place| {
            scratch.share_last_plane(&mut place.1);
            place.0 = slab + 1;
        });
        if scratch.lacks_first_plane() {
            self.at(slab, |place| {
                if place.0 == slab {
                    scratch.take_first_plane(&mut place.1);
                    place.0 = usize::MAX;
                }
            });
        }
    }

    fn at(&self, slab: usize, f: impl FnOnce(&mut (usize, SharedPlane))) {
        if let Some(n) = slab.checked_rem(self.places.len()) {
            f(&mut self.places[n].lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}
