//! The workers: each takes a slab, counts it, learns its first ids, fills it, and hands it on.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::dispense::Dispenser;
use super::handover::Handover;
use super::plan::Plan;
use super::sequence::{Sequence, Stop};
use super::{RunError, RunOptions};
use crate::geom::Dims;
use crate::kernel::{Classify, Kernel, Scratch, Slab, Totals};
use crate::limits::{MAX_TRIANGLES, MAX_VERTICES};
use crate::source::Planes;
use crate::volume::Note;

/// Where the patches of one surface go.
pub(super) trait Output<T: Classify>: Sync {
    /// What is handed out in slab order, under a lock, when a slab's totals are known.
    type Claim;
    /// What it is handed out from.
    type Store: Send;
    /// What a worker reuses from slab to slab.
    type Buffers: Default;

    /// Planes that it needs on either side of those that a slab's cells touch.
    fn halo(&self) -> usize {
        0
    }

    /// The store of a surface of which nothing is claimed yet.
    fn store(&mut self) -> Self::Store;

    /// Sets a slab's place aside.
    fn claim(store: &mut Self::Store, totals: Totals) -> Result<Self::Claim, RunError>;

    /// Fills a counted slab and hands it on; with the stop flag, for waiting.
    fn put(
        &self,
        counted: Counted<'_, T>,
        claim: Self::Claim,
        buffers: &mut Self::Buffers,
        stop: &Stop,
    ) -> Result<Spent, RunError>;

    /// Wakes whoever waits for a turn.
    fn wake(&self);
}

/// A slab that was counted and numbered.
pub(super) struct Counted<'a, T: Classify> {
    pub(super) number: usize,
    pub(super) kernel: &'a Kernel<T>,
    pub(super) slab: &'a Slab<'a, T>,
    pub(super) scratch: &'a Scratch,
    /// Vertices of the slabs before.
    pub(super) first_vertex: u32,
}

/// Time spent on a slab.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spent {
    pub(super) read: Duration,
    pub(super) mesh: Duration,
    pub(super) write: Duration,
}

impl std::ops::AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.read += other.read;
        self.mesh += other.mesh;
        self.write += other.write;
    }
}

/// What a run of several surfaces comes to.
pub(super) struct Outcome {
    pub(super) totals: Vec<Totals>,
    pub(super) spent: Spent,
    pub(super) notes: Vec<Note>,
}

/// One surface on its way: its kernel, where it goes, and what is numbered so far.
struct Track<'a, T: Classify, O: Output<T>> {
    kernel: Kernel<T>,
    output: &'a O,
    handover: Handover,
    ledger: Sequence<(Totals, O::Store)>,
}

/// Meshes all surfaces of a volume.
pub(super) fn run<T: Classify, O: Output<T>>(
    planes: Planes<'_, T>,
    dims: Dims,
    surfaces: Vec<(Kernel<T>, &mut O)>,
    options: &RunOptions<'_>,
) -> Result<Outcome, RunError> {
    let threads = options.threads.max(1);
    let halo = surfaces.iter().map(|(_, output)| output.halo()).max().unwrap_or(0);
    let plan = Plan::new(dims, size_of::<T>(), threads, options.slab_planes, halo);
    let threads = threads.min(plan.n_slabs());
    let surfaces: Vec<_> = surfaces
        .into_iter()
        .map(|(kernel, output)| {
            let ledger = Sequence::new((Totals::default(), output.store()));
            Track { kernel, output: &*output, handover: Handover::new(threads), ledger }
        })
        .collect();
    let job = Job {
        dispenser: Dispenser::new(planes, dims, plan, options.cancel.clone()),
        surfaces: &surfaces,
        plane_len: dims.plane_len(),
        options,
        stop: Stop::default(),
        n_layers_done: AtomicUsize::new(0),
        n_planes: dims.nz(),
    };
    // One worker a thread, all at once: a worker may wait for another's turn.
    let spent = if threads == 1 {
        vec![job.work()]
    } else {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|_| RunError::Internal("worker threads could not be started"))?
            .broadcast(|_| job.work())
    };
    let Job { dispenser, stop, .. } = job;
    stop.into_result()?;
    let notes = dispenser.finish()?;
    let mut outcome = Outcome { totals: Vec::new(), spent: Spent::default(), notes };
    for each in spent {
        outcome.spent += each;
    }
    outcome.totals = surfaces.into_iter().map(|s| s.ledger.into_inner().0).collect();
    Ok(outcome)
}

struct Job<'a, 's, T: Classify, O: Output<T>> {
    dispenser: Dispenser<'a, T>,
    surfaces: &'s [Track<'s, T, O>],
    plane_len: usize,
    options: &'s RunOptions<'s>,
    stop: Stop,
    n_layers_done: AtomicUsize,
    n_planes: usize,
}

impl<T: Classify, O: Output<T>> Job<'_, '_, T, O> {
    /// Works until there is no slab left or the run is stopped.
    fn work(&self) -> Spent {
        let mut spent = Spent::default();
        let mut own: Vec<(Scratch, O::Buffers)> =
            self.surfaces.iter().map(|_| Default::default()).collect();
        let _guard = StopAtPanic(self);
        while !self.stop.is_raised() {
            match self.slab(&mut own, &mut spent) {
                Ok(true) => {}
                Ok(false) => break,
                Err((slab, error)) => self.stop(slab, error),
            }
        }
        spent
    }

    fn stop(&self, slab: usize, error: RunError) {
        self.stop.raise(slab, error);
        for surface in self.surfaces {
            surface.ledger.wake();
            surface.output.wake();
        }
    }

    /// Takes the next slab through all surfaces; says whether there was one.
    fn slab(
        &self,
        own: &mut [(Scratch, O::Buffers)],
        spent: &mut Spent,
    ) -> Result<bool, (usize, RunError)> {
        let begun = Instant::now();
        let Some(lease) = self.dispenser.next()? else { return Ok(false) };
        spent.read += begun.elapsed();
        let number = lease.slab;
        let planes = lease.planes(self.plane_len);
        let slab =
            Slab { layers: lease.layers.clone(), first_plane: lease.first_plane, planes: &planes };
        for (surface, (scratch, buffers)) in self.surfaces.iter().zip(own) {
            let begun = Instant::now();
            if self.options.cancel.is_raised() {
                return Err((number, RunError::Interrupted));
            }
            surface.kernel.classify(&slab, scratch);
            surface.handover.exchange(number, scratch);
            let totals = surface.kernel.count(&slab, scratch);
            spent.mesh += begun.elapsed();
            let entered = surface.ledger.in_turn(&self.stop, number, |(sum, store)| {
                let first = sum.n_vertices;
                *sum = checked_sum(*sum, totals)?;
                Ok((first as u32, O::claim(store, totals)?))
            });
            let Some((first_vertex, claim)) = entered.map_err(|e| (number, e))? else {
                return Ok(false);
            };
            let counted =
                Counted { number, kernel: &surface.kernel, slab: &slab, scratch, first_vertex };
            let put = surface.output.put(counted, claim, buffers, &self.stop);
            *spent += put.map_err(|e| (number, e))?;
        }
        if let Some(progress) = self.options.progress {
            let n = slab.layers.len();
            let done = self.n_layers_done.fetch_add(n, Ordering::Relaxed) + n;
            progress.planes(done.min(self.n_planes), self.n_planes);
        }
        Ok(true)
    }
}

/// Stops the others where a worker panics, as a caller's formula or progress may: they would wait
/// for its turn for ever, and the panic go nowhere.
struct StopAtPanic<'j, 'a, 's, T: Classify, O: Output<T>>(&'j Job<'a, 's, T, O>);

impl<T: Classify, O: Output<T>> Drop for StopAtPanic<'_, '_, '_, T, O> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.stop(usize::MAX, RunError::Internal("a worker panicked"));
        }
    }
}

/// Ids are `u32`: what comes to more is refused before any of it is made.
fn checked_sum(sum: Totals, more: Totals) -> Result<Totals, RunError> {
    let sum = Totals {
        n_vertices: sum.n_vertices + more.n_vertices,
        n_triangles: sum.n_triangles + more.n_triangles,
    };
    if sum.n_vertices > MAX_VERTICES {
        return Err(RunError::TooMany { what: "vertices", limit: MAX_VERTICES });
    }
    if sum.n_triangles > MAX_TRIANGLES {
        return Err(RunError::TooMany { what: "triangles", limit: MAX_TRIANGLES });
    }
    Ok(sum)
}
