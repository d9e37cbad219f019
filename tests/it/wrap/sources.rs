//! One small volume behind each of the three ways to have planes, and a way to read them all.

use std::sync::Mutex;

use mcubes::geom::{Affine, Dims, Grid};
use mcubes::source::{AnyPlanes, OrderedPlanes, Planes, PositionedPlanes, SourceError, Volume};
use mcubes::volume::{Meta, Note, Sample, SourceFormat};
use mcubes::with_planes;
use ndarray::{Array3, ArrayView3, ArrayViewMut2, Axis, s};

/// The three ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Way {
    Ordered,
    Positioned,
    Resident,
}

pub(super) const WAYS: [Way; 3] = [Way::Ordered, Way::Positioned, Way::Resident];

/// What was asked of a source: planes read, rows read as (plane, first, how many), and whether it
/// was finished.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) planes: Mutex<Vec<usize>>,
    pub(super) rows: Mutex<Vec<(usize, usize, usize)>>,
    pub(super) finished: Mutex<bool>,
    /// Whether rows can be had.
    pub(super) has_rows: bool,
}

struct Stored<'a, T> {
    array: ArrayView3<'a, T>,
    log: &'a Log,
    next: usize,
}

impl<T: Sample> OrderedPlanes<T> for Stored<'_, T> {
    fn next_plane(&mut self, out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        self.next += 1;
        self.read_plane(self.next - 1, out)
    }

    fn finish(&mut self) -> Result<Vec<Note>, SourceError> {
        assert_eq!(self.next, self.array.len_of(Axis(0)), "finished before its last plane");
        *self.log.finished.lock().unwrap() = true;
        Ok(vec![Note::AffineFromPixdim])
    }
}

impl<T: Sample> PositionedPlanes<T> for Stored<'_, T> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        self.log.planes.lock().unwrap().push(k);
        out.assign(&self.array.index_axis(Axis(0), k));
        Ok(())
    }

    fn read_rows(
        &self,
        k: usize,
        first: usize,
        mut out: ArrayViewMut2<'_, T>,
    ) -> Result<bool, SourceError> {
        if self.log.has_rows {
            self.log.rows.lock().unwrap().push((k, first, out.nrows()));
            let end = first + out.nrows();
            out.assign(&self.array.slice(s![k, first..end, ..]));
        }
        Ok(self.log.has_rows)
    }
}

/// An oblique affine, so that no axis is taken for another.
pub(super) fn affine() -> Affine {
    Affine::from_columns([0.6, 0.8, 0.0], [-1.6, 1.2, 0.0], [0.25, 0.0, 3.0], [10.0, -20.0, 30.0])
}

pub(super) fn dims_of<T>(array: &Array3<T>) -> Dims {
    let (nz, ny, nx) = array.dim();
    Dims::checked(nx as i64, ny as i64, nz as i64, 8).unwrap()
}

/// Planes of an array (z, y, x), had in one of the ways.
pub(super) fn planes<'a, T: Sample>(array: &'a Array3<T>, way: Way, log: &'a Log) -> Planes<'a, T> {
    let stored = Stored { array: array.view(), log, next: 0 };
    match way {
        Way::Ordered => Planes::Ordered(Box::new(stored)),
        Way::Positioned => Planes::Positioned(Box::new(stored)),
        Way::Resident => Planes::Resident(array.view()),
    }
}

/// A volume on the oblique grid around planes.
pub(super) fn volume<T: Sample>(dims: Dims, planes: AnyPlanes<'_>) -> Volume<'_> {
    Volume { meta: Meta::plain(SourceFormat::Memory, Grid::new(dims, affine()), T::TYPE), planes }
}

fn collect<T: Sample>(planes: Planes<'_, T>, dims: Dims) -> Array3<f64> {
    let mut all = Array3::from_elem((dims.nz(), dims.ny(), dims.nx()), T::default());
    match planes {
        Planes::Ordered(mut inner) => {
            for plane in all.outer_iter_mut() {
                inner.next_plane(plane).unwrap();
            }
            inner.finish().unwrap();
        }
        Planes::Positioned(inner) => {
            // Backwards, since any order is promised.
            for k in (0..dims.nz()).rev() {
                inner.read_plane(k, all.index_axis_mut(Axis(0), k)).unwrap();
            }
        }
        Planes::Resident(view) => all.assign(&view),
    }
    all.mapv(Sample::to_f64)
}

/// All samples of a volume, as they are stored.
pub(crate) fn read(volume: Volume<'_>) -> Array3<f64> {
    let dims = volume.meta.grid.dims;
    with_planes!(volume.planes, planes => collect(planes, dims))
}

/// The way a volume's planes can be had.
pub(super) fn way(volume: &Volume<'_>) -> Way {
    with_planes!(&volume.planes, planes => match planes {
        Planes::Ordered(_) => Way::Ordered,
        Planes::Positioned(_) => Way::Positioned,
        Planes::Resident(_) => Way::Resident,
    })
}

/// Whether two arrays have the same values, NaN for NaN.
pub(crate) fn same(a: &Array3<f64>, b: &Array3<f64>) -> bool {
    a.dim() == b.dim() && a.iter().zip(b).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}
