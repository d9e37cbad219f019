//! The bits of planes that two slabs share, handed from worker to worker so that a plane is
//! compared once. A matter of speed alone: what is not there is compared again.

use std::sync::{Mutex, PoisonError};

use crate::kernel::{Scratch, SharedPlane};

/// A slot for each worker, and one more: a slab leaves its last plane before the slab after it has
/// taken its own.
#[derive(Debug)]
pub(super) struct Handover {
    slots: Vec<Mutex<(usize, SharedPlane)>>,
}

impl Handover {
    /// For some workers; a lone one keeps its own last plane.
    pub(super) fn new(workers: usize) -> Self {
        let n = if workers > 1 { workers + 1 } else { 0 };
        Self { slots: (0..n).map(|_| Mutex::default()).collect() }
    }

    /// Called with the planes of a slab classified: leaves the last for the slab after it, and takes
    /// the first from the slab before it if that one was quicker.
    pub(super) fn exchange(&self, slab: usize, scratch: &mut Scratch) {
        self.at(slab + 1, |slot| {
            scratch.share_last_plane(&mut slot.1);
            slot.0 = slab + 1;
        });
        if scratch.lacks_first_plane() {
            self.at(slab, |slot| {
                if slot.0 == slab {
                    scratch.take_first_plane(&mut slot.1);
                    slot.0 = usize::MAX;
                }
            });
        }
    }

    fn at(&self, slab: usize, f: impl FnOnce(&mut (usize, SharedPlane))) {
        if let Some(n) = slab.checked_rem(self.slots.len()) {
            f(&mut self.slots[n].lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}
