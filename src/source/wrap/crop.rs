//! A box of a volume's samples: what lies outside is not read, or dropped where it must be.

use std::ops::Range;

use ndarray::{ArrayView2, ArrayViewMut2, s};

use super::lend::{Pool, internal, plane};
use super::{WrapError, any};
use crate::geom::Dims;
use crate::source::{OrderedPlanes, Planes, PositionedPlanes, SourceError, Volume};
use crate::volume::{Inside, Note, Sample};

/// The samples whose indices lie in three half-open ranges, along i, j and k. They stay where they
/// were in millimetres, and voxel coordinates stay those of the whole volume.
///
/// Of planes that can be had in any order only those in the box are read, and of them only the rows
/// in the box where the source can do so; an array in memory is looked at through a smaller view.
/// Planes that come one after another are read to the end, so that the end of the stream is
/// checked, and dropped outside the box.
///
/// # Errors
/// [`WrapError::Regrid`] for a range that is empty or leaves the volume.
pub fn crop<'a>(volume: Volume<'a>, ranges: &[Range<usize>; 3]) -> Result<Volume<'a>, SourceError> {
    let Volume { mut meta, planes } = volume;
    let whole = meta.grid.dims;
    meta.grid = meta.grid.cropped(ranges).map_err(WrapError::from)?;
    meta.gaps_mm = meta.grid.gaps_mm();
    let planes = any!(planes, inner => window(inner, whole, ranges)?);
    Ok(Volume { meta, planes })
}

fn window<'a, T: Sample>(
    planes: Planes<'a, T>,
    whole: Dims,
    ranges: &[Range<usize>; 3],
) -> Result<Planes<'a, T>, SourceError> {
    let [i, j, k] = ranges.clone();
    let window = Window { whole, i, j, k, pool: Pool::new(whole.plane_len()) };
    Ok(match planes {
        Planes::Ordered(inner) => Planes::Ordered(Box::new(Ordered { inner, window, next: 0 })),
        Planes::Positioned(inner) => Planes::Positioned(Box::new(Positioned { inner, window })),
        Planes::Resident(view) => {
            let n = whole.to_array();
            if view.shape() != [n[2], n[1], n[0]] {
                return Err(internal("an array of other dimensions than its volume"));
            }
            let Window { i, j, k, .. } = window;
            Planes::Resident(view.slice_move(s![k, j, i]))
        }
    })
}

/// The box, and buffers for whole planes.
struct Window<T> {
    whole: Dims,
    i: Range<usize>,
    j: Range<usize>,
    k: Range<usize>,
    pool: Pool<T>,
}

impl<T: Sample> Window<T> {
    /// Whether the box holds whole planes.
    fn is_full(&self) -> bool {
        self.i == (0..self.whole.nx()) && self.j == (0..self.whole.ny())
    }

    /// The box's part of some whole rows, the first of which is row `first` of the plane.
    fn copy(
        &self,
        rows: &[T],
        first: usize,
        mut out: ArrayViewMut2<'_, T>,
    ) -> Result<(), SourceError> {
        let nx = self.whole.nx();
        let rows = ArrayView2::from_shape((rows.len() / nx, nx), rows)
            .map_err(|_| internal("rows of another length"))?;
        let (from, to) = (self.j.start - first, self.j.end - first);
        if to > rows.nrows() || out.dim() != (self.j.len(), self.i.len()) {
            return Err(internal("a plane was lent that is not of its size"));
        }
        out.assign(&rows.slice(s![from..to, self.i.clone()]));
        Ok(())
    }
}

struct Ordered<'a, T> {
    inner: Box<dyn OrderedPlanes<T> + 'a>,
    window: Window<T>,
    /// The plane that the inner source gives next.
    next: usize,
}

impl<T: Sample> Ordered<'_, T> {
    /// Reads planes up to `k`, which is not read, and drops them.
    fn skip_to(&mut self, k: usize) -> Result<(), SourceError> {
        if self.next < k {
            let mut dropped = self.window.pool.lend()?;
            while self.next < k {
                self.inner.next_plane(plane(&mut dropped, self.window.whole.nx())?)?;
                self.next += 1;
            }
        }
        Ok(())
    }
}

impl<T: Sample> OrderedPlanes<T> for Ordered<'_, T> {
    fn next_plane(&mut self, out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        self.skip_to(self.window.k.start)?;
        self.next += 1;
        if self.window.is_full() {
            return self.inner.next_plane(out);
        }
        let mut whole = self.window.pool.lend()?;
        self.inner.next_plane(plane(&mut whole, self.window.whole.nx())?)?;
        self.window.copy(&whole, 0, out)
    }

    fn finish(&mut self) -> Result<Vec<Note>, SourceError> {
        self.skip_to(self.window.whole.nz())?;
        self.inner.finish()
    }
}

struct Positioned<'a, T> {
    inner: Box<dyn PositionedPlanes<T> + 'a>,
    window: Window<T>,
}

impl<T: Sample> PositionedPlanes<T> for Positioned<'_, T> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        let Window { whole, i, j, k: planes, pool } = &self.window;
        let k = planes.start + k;
        if self.window.is_full() {
            return self.inner.read_plane(k, out);
        }
        if i.len() == whole.nx() && self.inner.read_rows(k, j.start, out.view_mut())? {
            return Ok(());
        }
        let mut buffer = pool.lend()?;
        let rows = buffer.get_mut(..j.len() * whole.nx()).unwrap_or_default();
        if self.inner.read_rows(k, j.start, plane(rows, whole.nx())?)? {
            return self.window.copy(rows, j.start, out);
        }
        self.inner.read_plane(k, plane(&mut buffer, whole.nx())?)?;
        self.window.copy(&buffer, 0, out)
    }

    fn read_rows(
        &self,
        k: usize,
        first: usize,
        out: ArrayViewMut2<'_, T>,
    ) -> Result<bool, SourceError> {
        let Window { whole, i, j, k: planes, .. } = &self.window;
        if i.len() == whole.nx() {
            self.inner.read_rows(planes.start + k, j.start + first, out)
        } else {
            Ok(false)
        }
    }

    fn keep_padding(&mut self, inside: Inside) {
        self.inner.keep_padding(inside);
    }
}
