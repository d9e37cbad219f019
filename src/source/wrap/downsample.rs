//! Means of blocks of samples.

use std::ops::{Add, AddAssign};

use ndarray::ArrayViewMut2;

use super::WrapError;
use super::lend::{Pool, plane, samples};
use super::valid::Valid;
use crate::geom::Dims;
use crate::source::each::Either;
use crate::source::{AnyPlanes, OrderedPlanes, Planes, PositionedPlanes, SourceError, Volume};
use crate::volume::{Meta, Note, Sample, StoredType};
use crate::with_planes;

/// The mean of each block of `n` samples along i, j and k, at the block's centre; a last block that
/// is short is averaged over what it has and keeps the grid's step. NaN and padding are left out; a
/// block of nothing else is NaN.
///
/// Sums are made of stored values, in one order whatever the threads, and divided once; the rescale
/// stays, so real values are means of real values. Sums of integers are exact, others are `f64`.
///
/// # Errors
/// [`WrapError::Regrid`] where one of `n` is 0.
///
/// # Cost
/// A thread, one plane of the source, and one of its width by the rows of blocks for the sums.
pub fn downsample(volume: Volume<'_>, n: [usize; 3]) -> Result<Volume<'_>, SourceError> {
    if n == [1; 3] {
        return Ok(volume);
    }
    let Volume { mut meta, planes } = volume;
    let grid = meta.grid.blocks(n).map_err(WrapError::from)?;
    let planes = with_planes!(planes, inner => AnyPlanes::F64(means(inner, &meta, n)));
    meta.gaps_mm = grid.gaps_mm();
    meta.grid = grid;
    (meta.padding, meta.uneven_padding) = (None, None);
    Ok(Volume { meta, planes })
}

fn means<'a, T: Sample>(planes: Planes<'a, T>, meta: &Meta, n: [usize; 3]) -> Planes<'a, f64> {
    let size = meta.grid.dims.to_array();
    let n = [0, 1, 2].map(|a| n[a].min(size[a]));
    // 32 bits hold the sum of 2^15 samples of 16 bits, as many as stand in a column of a block.
    let is_short = n[1].saturating_mul(n[2]) <= 1 << 15;
    match T::TYPE {
        StoredType::U8 | StoredType::I8 | StoredType::U16 | StoredType::I16 if is_short => {
            means_by::<T, i32>(planes, meta, n)
        }
        _ => means_by::<T, f64>(planes, meta, n),
    }
}

/// What samples are added up in.
trait Total: Sample + AddAssign + Add<Output = Self> {
    fn of<T: Sample>(sample: T) -> Self;
}

impl Total for f64 {
    #[inline(always)]
    fn of<T: Sample>(sample: T) -> Self {
        sample.to_f64()
    }
}

impl Total for i32 {
    /// Of integers, whose places in their order are their values.
    #[inline(always)]
    fn of<T: Sample>(sample: T) -> Self {
        sample.ordinal() as i32
    }
}

fn means_by<'a, T: Sample, S: Total>(
    planes: Planes<'a, T>,
    meta: &Meta,
    n: [usize; 3],
) -> Planes<'a, f64> {
    let dims = meta.grid.dims;
    let valid = Valid::new(meta);
    let n_rows = dims.ny().div_ceil(n[1]);
    let n_counts = if valid.all() { 0 } else { n_rows * dims.nx() };
    let blocks = Blocks::<T, S> {
        dims,
        n,
        valid,
        planes: Pool::new(dims.plane_len()),
        sums: Pool::new(n_rows * dims.nx()),
        counts: Pool::new(n_counts),
    };
    match planes.into() {
        Either::Ordered(inner) => Planes::Ordered(Box::new(Ordered { inner, blocks, next: 0 })),
        Either::Positioned(inner) => Planes::Positioned(Box::new(Positioned { inner, blocks })),
    }
}

/// The blocks, and buffers: planes of samples, and sums down the columns of blocks, the source's
/// width by rows of blocks.
struct Blocks<T, S> {
    dims: Dims,
    n: [usize; 3],
    valid: Valid<T>,
    planes: Pool<T>,
    sums: Pool<S>,
    counts: Pool<f64>,
}

impl<T: Sample, S: Total> Blocks<T, S> {
    /// Makes plane `block` of means from the planes that `read` gives, first to last.
    fn make(
        &self,
        block: usize,
        mut out: ArrayViewMut2<'_, f64>,
        mut read: impl FnMut(usize, ArrayViewMut2<'_, T>) -> Result<(), SourceError>,
    ) -> Result<(), SourceError> {
        let (nx, [ni, nj, nk]) = (self.dims.nx(), self.n);
        let (n_columns, n_rows) = (nx.div_ceil(ni), self.dims.ny().div_ceil(nj));
        let out = samples(&mut out, n_columns * n_rows)?;
        let mut buffer = self.planes.lend()?;
        let mut sums = self.sums.lend()?;
        let mut counts = self.counts.lend()?;
        sums.fill(S::default());
        counts.fill(0.0);
        let planes = block * nk..self.dims.nz().min((block + 1) * nk);
        let n_planes = planes.len();
        for k in planes {
            read(k, plane(&mut buffer, nx)?)?;
            self.add(&buffer, &mut sums, &mut counts);
        }
        for (row, out) in out.chunks_exact_mut(n_columns).enumerate() {
            let sums = sums.chunks_exact(nx).nth(row).unwrap_or_default();
            let height = nj.min(self.dims.ny() - row * nj) * n_planes;
            if counts.is_empty() {
                // Blocks of two, the usual ones, by a loop without another in it.
                let twos = if ni == 2 { sums.as_chunks::<2>().0 } else { &[] };
                let (pairs, rest) = out.split_at_mut(twos.len());
                for (mean, [a, b]) in pairs.iter_mut().zip(twos) {
                    *mean = (a.to_f64() + b.to_f64()) / (2 * height) as f64;
                }
                for (mean, block) in rest.iter_mut().zip(sums[ni * twos.len()..].chunks(ni)) {
                    *mean = total(block) / (block.len() * height) as f64;
                }
            } else {
                let counts = counts.chunks_exact(nx).nth(row).unwrap_or_default();
                for ((mean, block), n) in out.iter_mut().zip(sums.chunks(ni)).zip(counts.chunks(ni))
                {
                    // 0 / 0 is the NaN that a block of nothing is.
                    *mean = total(block) / total(n);
                }
            }
        }
        Ok(())
    }

    /// Adds a plane's rows to the rows of blocks they are in, at full width.
    fn add(&self, from: &[T], sums: &mut [S], counts: &mut [f64]) {
        let (nx, nj) = (self.dims.nx(), self.n[1]);
        if counts.is_empty() {
            for (rows, sums) in from.chunks(nx * nj).zip(sums.chunks_exact_mut(nx)) {
                // Two rows at a time: the sums are read and written half as often.
                for pair in rows.chunks(2 * nx) {
                    let (row, next) = pair.split_at(nx);
                    if next.is_empty() {
                        for (&x, sum) in row.iter().zip(sums.iter_mut()) {
                            *sum += S::of(x);
                        }
                    } else {
                        for ((&x, &y), sum) in row.iter().zip(next).zip(sums.iter_mut()) {
                            *sum += S::of(x) + S::of(y);
                        }
                    }
                }
            }
            return;
        }
        let targets = sums.chunks_exact_mut(nx).zip(counts.chunks_exact_mut(nx));
        for (rows, (sums, counts)) in from.chunks(nx * nj).zip(targets) {
            for row in rows.chunks_exact(nx) {
                for ((&x, sum), count) in row.iter().zip(sums.iter_mut()).zip(counts.iter_mut()) {
                    let is_valid = self.valid.holds(x);
                    *sum += if is_valid { S::of(x) } else { S::default() };
                    *count += f64::from(u8::from(is_valid));
                }
            }
        }
    }
}

fn total<S: Total>(sums: &[S]) -> f64 {
    sums.iter().map(|sum| sum.to_f64()).sum()
}

struct Ordered<'a, T, S> {
    inner: Box<dyn OrderedPlanes<T> + 'a>,
    blocks: Blocks<T, S>,
    next: usize,
}

impl<T: Sample, S: Total> OrderedPlanes<f64> for Ordered<'_, T, S> {
    fn next_plane(&mut self, out: ArrayViewMut2<'_, f64>) -> Result<(), SourceError> {
        let block = self.next;
        self.next += 1;
        self.blocks.make(block, out, |_, plane| self.inner.next_plane(plane))
    }

    fn finish(&mut self) -> Result<Vec<Note>, SourceError> {
        self.inner.finish()
    }
}

struct Positioned<'a, T, S> {
    inner: Box<dyn PositionedPlanes<T> + 'a>,
    blocks: Blocks<T, S>,
}

impl<T: Sample, S: Total> PositionedPlanes<f64> for Positioned<'_, T, S> {
    fn read_plane(&self, k: usize, out: ArrayViewMut2<'_, f64>) -> Result<(), SourceError> {
        self.blocks.make(k, out, |k, plane| self.inner.read_plane(k, plane))
    }
}
