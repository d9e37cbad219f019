//! The dispenser: hands out slabs in order and reads each plane once, for all slabs that need it.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use ndarray::ArrayViewMut2;

use super::RunError;
use super::plan::Plan;
use super::pool::{PlaneBuffer, Pool};
use super::sequence::lock;
use crate::cancel::Cancel;
use crate::geom::Dims;
use crate::source::{Copied, OrderedPlanes, Planes, PositionedPlanes, SourceError};
use crate::volume::{Note, Sample};

/// Hands out slabs to any number of workers. A slab's planes are read by the worker that asked for
/// it: streams one worker at a time, in order; positioned planes side by side.
pub(super) struct Dispenser<'a, T> {
    plan: Plan,
    dims: Dims,
    cancel: Cancel,
    pool: Arc<Pool<T>>,
    next: AtomicUsize,
    supply: Supply<'a, T>,
}

enum Supply<'a, T> {
    /// Lent as they stand in memory.
    Contiguous(&'a [T]),
    /// One slot a plane, so that a plane is read by the first who needs it, others wait for it, and
    /// the last who needs it takes it away.
    Slots {
        planes: Box<dyn PositionedPlanes<T> + 'a>,
        slots: Vec<Mutex<Slot<T>>>,
    },
    Stream(Mutex<Stream<'a, T>>),
}

struct Slot<T> {
    uses_left: usize,
    plane: Option<Arc<PlaneBuffer<T>>>,
}

struct Stream<'a, T> {
    planes: Box<dyn OrderedPlanes<T> + 'a>,
    next_slab: usize,
    next_plane: usize,
    /// The planes last read that the next slab needs too, with the number of the first.
    held: VecDeque<Arc<PlaneBuffer<T>>>,
}

/// The planes of one slab, held until the slab is done.
pub(super) struct Lease<'a, T> {
    pub(super) slab: usize,
    pub(super) layers: Range<usize>,
    pub(super) first_plane: usize,
    planes: LeasedPlanes<'a, T>,
}

enum LeasedPlanes<'a, T> {
    Lent(&'a [T]),
    Held(Vec<Arc<PlaneBuffer<T>>>),
}

impl<'a, T: Sample> Dispenser<'a, T> {
    pub(super) fn new(planes: Planes<'a, T>, dims: Dims, plan: Plan, cancel: Cancel) -> Self {
        let slots = |planes| {
            let slot = |uses_left| Mutex::new(Slot { uses_left, plane: None });
            Supply::Slots { planes, slots: plan.uses().into_iter().map(slot).collect() }
        };
        let supply = match planes {
            Planes::Positioned(planes) => slots(planes),
            Planes::Ordered(planes) => Supply::Stream(Mutex::new(Stream {
                planes,
                next_slab: 0,
                next_plane: 0,
                held: VecDeque::new(),
            })),
            Planes::Resident(array) => match array.to_slice() {
                Some(samples) => Supply::Contiguous(samples),
                None => slots(Box::new(Copied(array))),
            },
        };
        let pool = Pool::new(dims.plane_len());
        Self { plan, dims, cancel, pool, next: AtomicUsize::new(0), supply }
    }

    /// The next slab with its planes, or nothing after the last.
    pub(super) fn next(&self) -> Result<Option<Lease<'a, T>>, (usize, RunError)> {
        match &self.supply {
            Supply::Contiguous(samples) => {
                let slab = self.next.fetch_add(1, Ordering::Relaxed);
                Ok(self.lease(slab, |planes| {
                    let len = self.dims.plane_len();
                    LeasedPlanes::Lent(&samples[planes.start * len..planes.end * len])
                }))
            }
            Supply::Slots { planes, slots } => {
                let slab = self.next.fetch_add(1, Ordering::Relaxed);
                if slab >= self.plan.n_slabs() {
                    return Ok(None);
                }
                let held = self
                    .plan
                    .planes(slab)
                    .map(|k| self.take(planes.as_ref(), &slots[k], k))
                    .collect::<Result<_, _>>()
                    .map_err(|e| (slab, e))?;
                Ok(self.lease(slab, |_| LeasedPlanes::Held(held)))
            }
            Supply::Stream(stream) => {
                let mut stream = lock(stream);
                let slab = stream.next_slab;
                if slab >= self.plan.n_slabs() {
                    return Ok(None);
                }
                stream.next_slab += 1;
                let held = self.read_on(&mut stream, slab).map_err(|e| (slab, e))?;
                Ok(self.lease(slab, |_| LeasedPlanes::Held(held)))
            }
        }
    }

    fn lease(
        &self,
        slab: usize,
        planes: impl FnOnce(Range<usize>) -> LeasedPlanes<'a, T>,
    ) -> Option<Lease<'a, T>> {
        (slab < self.plan.n_slabs()).then(|| {
            let range = self.plan.planes(slab);
            let (layers, first_plane) = (self.plan.layers(slab), range.start);
            Lease { slab, layers, first_plane, planes: planes(range) }
        })
    }

    /// Plane `k`, read here if nobody has read it yet.
    fn take(
        &self,
        planes: &dyn PositionedPlanes<T>,
        slot: &Mutex<Slot<T>>,
        k: usize,
    ) -> Result<Arc<PlaneBuffer<T>>, RunError> {
        let mut slot = lock(slot);
        let plane = match slot.plane.take() {
            Some(plane) => plane,
            None => self.fill(|out| planes.read_plane(k, out))?,
        };
        slot.uses_left -= 1;
        if slot.uses_left > 0 {
            slot.plane = Some(Arc::clone(&plane));
        }
        Ok(plane)
    }

    /// The planes of a slab, of which some were read for the slab before.
    fn read_on(
        &self,
        stream: &mut Stream<'_, T>,
        slab: usize,
    ) -> Result<Vec<Arc<PlaneBuffer<T>>>, RunError> {
        let range = self.plan.planes(slab);
        let mut held = std::mem::take(&mut stream.held);
        while stream.next_plane < range.end {
            let plane = self.fill(|out| stream.planes.next_plane(out))?;
            held.push_back(plane);
            stream.next_plane += 1;
        }
        let first_held = range.end - held.len();
        let held: Vec<_> = held.into_iter().skip(range.start - first_held).collect();
        if slab + 1 < self.plan.n_slabs() {
            let needed = self.plan.planes(slab + 1).start.max(range.start);
            stream.held = held[needed - range.start..].iter().cloned().collect();
        }
        Ok(held)
    }

    fn fill(
        &self,
        read: impl FnOnce(ArrayViewMut2<'_, T>) -> Result<(), SourceError>,
    ) -> Result<Arc<PlaneBuffer<T>>, RunError> {
        if self.cancel.is_raised() {
            return Err(RunError::Interrupted);
        }
        self.pool.lend(|samples| {
            let out = ArrayViewMut2::from_shape((self.dims.ny(), self.dims.nx()), samples)
                .map_err(|_| RunError::Internal("a plane buffer of the wrong size"))?;
            read(out).map_err(RunError::from)
        })
    }

    /// Called after the last slab: lets a stream check what only its end can tell.
    pub(super) fn finish(self) -> Result<Vec<Note>, RunError> {
        match self.supply {
            Supply::Stream(stream) => {
                let mut stream = stream.into_inner().unwrap_or_else(PoisonError::into_inner);
                Ok(stream.planes.finish()?)
            }
            _ => Ok(Vec::new()),
        }
    }
}

impl<T> Lease<'_, T> {
    /// The samples, a slice a plane.
    pub(super) fn planes(&self, plane_len: usize) -> Vec<&[T]> {
        match &self.planes {
            LeasedPlanes::Lent(samples) => samples.chunks_exact(plane_len).collect(),
            LeasedPlanes::Held(planes) => planes.iter().map(|plane| &plane[..]).collect(),
        }
    }
}
