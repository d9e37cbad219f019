//! A Gaussian blur as a source: holds the planes that a window of it needs, each blurred within
//! itself once.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::available_parallelism;

use ndarray::ArrayViewMut2;

use super::WrapError;
use super::gaussian::{Blurred, Gaussian};
use super::lend::{Pool, plane, samples};
use super::valid::Valid;
use crate::geom::Dims;
use crate::limits::MAX_PLANE_BYTES;
use crate::source::each::Either;
use crate::source::{AnyPlanes, OrderedPlanes, Planes, PositionedPlanes, SourceError, Volume};
use crate::volume::{Meta, Note, Sample};
use crate::with_planes;

/// The size of a slab of planes, about, that one thread asks for at a time.
const SLAB_BYTES: usize = 2 << 20;

/// A Gaussian of `sigma_mm` millimetres, each axis by its own spacing, cut off at 4 sigma as
/// scipy's `gaussian_filter` does. Borders are renormalised: samples beyond them do not exist. NaN
/// and padding are left out, and stay nothing: they are NaN in the result. 0 changes nothing.
///
/// Sums are made in `f64` of stored values, in one order whatever the threads; the rescale stays.
///
/// # Errors
/// Uneven planes, a sigma that is no length, a window of planes beyond the limit.
///
/// # Cost
/// 8 bytes a sample for `2 · int(4 sigma / spacing + ½) + 1` planes, and some planes a thread. Each
/// plane is read once as long as planes are asked for about in order.
pub fn blur(volume: Volume<'_>, sigma_mm: f64) -> Result<Volume<'_>, SourceError> {
    if !(sigma_mm.is_finite() && sigma_mm >= 0.0) {
        return Err(WrapError::Sigma(sigma_mm).into());
    }
    if sigma_mm == 0.0 {
        return Ok(volume);
    }
    let Volume { mut meta, planes } = volume;
    let (grid, dims) = (&meta.grid, meta.grid.dims);
    if grid.plane_origins.is_some() {
        return Err(WrapError::UnevenBlur.into());
    }
    let gaussian = Gaussian::new(dims, grid.affine.spacing().map(|step| sigma_mm / step))?;
    let window = 2 * gaussian.radius() as u64 + 1;
    let bytes = window.saturating_mul(dims.plane_len() as u64 * 8);
    // One plane is within the limit of its own, whatever its type becomes.
    if gaussian.radius() > 0 && bytes > MAX_PLANE_BYTES {
        return Err(WrapError::Window { planes: window, bytes, limit: MAX_PLANE_BYTES }.into());
    }
    let planes = with_planes!(planes, inner => AnyPlanes::F64(blurred(inner, &meta, gaussian)));
    (meta.padding, meta.uneven_padding) = (None, None);
    Ok(Volume { meta, planes })
}

fn blurred<'a, T: Sample>(
    planes: Planes<'a, T>,
    meta: &Meta,
    gaussian: Gaussian,
) -> Planes<'a, f64> {
    let dims = meta.grid.dims;
    let filter =
        Filter { dims, gaussian, valid: Valid::new(meta), pool: Pool::new(dims.plane_len()) };
    match planes.into() {
        Either::Ordered(inner) => Planes::Ordered(Box::new(Ordered {
            inner,
            filter,
            held: VecDeque::new(),
            first: 0,
            next: 0,
        })),
        Either::Positioned(inner) => {
            let most = most_held(dims, filter.gaussian.radius());
            let cache = Mutex::default();
            Planes::Positioned(Box::new(Positioned { inner, filter, cache, most }))
        }
    }
}

/// Planes worth keeping: a window, and a slab of planes a thread, since threads work on slabs side
/// by side; no more than there are.
fn most_held(dims: Dims, radius: usize) -> usize {
    let threads = available_parallelism().map_or(1, usize::from);
    let slab = (SLAB_BYTES / dims.plane_len().saturating_mul(8)).clamp(2, 64) + 1;
    (2 * radius + 1).saturating_add(threads.saturating_mul(slab)).min(dims.nz())
}

/// The filter, and buffers for planes of samples.
struct Filter<T> {
    dims: Dims,
    gaussian: Gaussian,
    valid: Valid<T>,
    pool: Pool<T>,
}

impl<T: Sample> Filter<T> {
    /// A plane, read and blurred within itself.
    fn load(
        &self,
        spare: Blurred,
        read: impl FnOnce(ArrayViewMut2<'_, T>) -> Result<(), SourceError>,
    ) -> Result<Blurred, SourceError> {
        let mut buffer = self.pool.lend()?;
        read(plane(&mut buffer, self.dims.nx())?)?;
        self.gaussian.within_plane(&buffer, &self.valid, spare)
    }

    /// The planes that take part in plane `k`.
    fn window(&self, k: usize) -> std::ops::Range<usize> {
        let radius = self.gaussian.radius();
        k.saturating_sub(radius)..self.dims.nz().min(k + radius + 1)
    }
}

struct Ordered<'a, T> {
    inner: Box<dyn OrderedPlanes<T> + 'a>,
    filter: Filter<T>,
    /// Planes from `first` on.
    held: VecDeque<Blurred>,
    first: usize,
    next: usize,
}

impl<T: Sample> OrderedPlanes<f64> for Ordered<'_, T> {
    fn next_plane(&mut self, mut out: ArrayViewMut2<'_, f64>) -> Result<(), SourceError> {
        let k = self.next;
        self.next += 1;
        let window = self.filter.window(k);
        let mut spare = Blurred::default();
        while self.first < window.start {
            spare = self.held.pop_front().unwrap_or_default();
            self.first += 1;
        }
        while self.first + self.held.len() < window.end {
            let inner = &mut self.inner;
            let buffers = std::mem::take(&mut spare);
            self.held.push_back(self.filter.load(buffers, |plane| inner.next_plane(plane))?);
        }
        let at = |k: usize| self.held.get(k.checked_sub(self.first)?);
        self.filter.gaussian.across(k, at, samples(&mut out, self.filter.dims.plane_len())?);
        Ok(())
    }

    fn finish(&mut self) -> Result<Vec<Note>, SourceError> {
        self.inner.finish()
    }
}

/// A plane that is being made by whoever holds the lock, or is made.
type Slot = Arc<Mutex<Option<Arc<Blurred>>>>;

struct Positioned<'a, T> {
    inner: Box<dyn PositionedPlanes<T> + 'a>,
    filter: Filter<T>,
    /// Planes that were wanted last, at most `most`, the last at the end. One that is wanted again
    /// after it had to go is made again: never wrong, only slow.
    cache: Mutex<Vec<(usize, Slot)>>,
    most: usize,
}

impl<T: Sample> Positioned<'_, T> {
    /// The plane, blurred within itself: made by one thread, waited for by the others. A thread
    /// that makes one waits for nobody, so none waits for ever.
    fn blurred(&self, k: usize) -> Result<Arc<Blurred>, SourceError> {
        let mut spare = Blurred::default();
        let slot = {
            let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
            let found = cache.iter().position(|(at, _)| *at == k).map(|n| cache.remove(n).1);
            if found.is_none() && cache.len() >= self.most {
                // The one that was not wanted for longest stands first.
                let (_, old) = cache.remove(0);
                spare = reclaimed(old).unwrap_or_default();
            }
            let slot = found.unwrap_or_default();
            cache.push((k, slot.clone()));
            slot
        };
        let mut made = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(plane) = made.as_ref() {
            return Ok(plane.clone());
        }
        let plane = Arc::new(self.filter.load(spare, |out| self.inner.read_plane(k, out))?);
        *made = Some(plane.clone());
        Ok(plane)
    }
}

/// The buffers of a plane that nobody looks at any more.
fn reclaimed(slot: Slot) -> Option<Blurred> {
    let made = Arc::into_inner(slot)?.into_inner().unwrap_or_else(PoisonError::into_inner)?;
    Arc::into_inner(made)
}

impl<T: Sample> PositionedPlanes<f64> for Positioned<'_, T> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, f64>) -> Result<(), SourceError> {
        let window = self.filter.window(k);
        let planes: Vec<_> = window.clone().map(|k| self.blurred(k)).collect::<Result<_, _>>()?;
        let at = |k: usize| planes.get(k.checked_sub(window.start)?).map(Arc::as_ref);
        self.filter.gaussian.across(k, at, samples(&mut out, self.filter.dims.plane_len())?);
        Ok(())
    }
}
