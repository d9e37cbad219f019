//! The front door for a volume in memory: a mesh in memory, each patch made at its final place.

use ndarray::ArrayView3;

use super::run::{Counted, Outcome, Output, Spent, run};
use super::sequence::Stop;
use super::{RunError, RunOptions, SurfaceOptions};
use crate::error::Error;
use crate::geom::{Dims, Grid, Place, Space};
use crate::kernel::{Classify, Kernel, PatchSlices, Totals, cpu};
use crate::limits::{MAX_TRIANGLES, MAX_VERTICES};
use crate::mesh::{Buffer, Position, Triangle};
use crate::source::{Planes, SourceError};
use crate::volume::Rescale;

/// A mesh in memory.
#[derive(Debug)]
pub struct Surface {
    /// Positions in the output space.
    pub vertices: Buffer<Position>,
    /// Counter-clockwise seen from outside.
    pub triangles: Buffer<Triangle>,
}

/// Meshes a volume in memory: (z, y, x) order, x fastest; any strides, contiguous is fast.
///
/// Vertices are in voxel indices; [`mesh_placed`] puts them into millimetres. A volume that nothing
/// in it reaches the iso value gives an empty mesh.
///
/// # Errors
/// A volume without samples or too large, or a mesh with more vertices than `u32` ids can name.
///
/// ```
/// use mcubes::pipeline::{RunOptions, SurfaceOptions};
///
/// let ball = ndarray::Array3::from_shape_fn((20, 20, 20), |(z, y, x)| {
///     let d = |i: usize| (i as f32 - 9.5).powi(2);
///     8.0 - (d(x) + d(y) + d(z)).sqrt()
/// });
/// let surface = mcubes::mesh(ball.view(), &SurfaceOptions::at(0.0), &RunOptions::default())?;
/// let (v, e, f) = (surface.vertices.len(), surface.triangles.len() * 3 / 2, surface.triangles.len());
/// assert_eq!(v + f - e, 2);
/// # Ok::<(), mcubes::Error>(())
/// ```
pub fn mesh<T: Classify>(
    volume: ArrayView3<'_, T>,
    surface: &SurfaceOptions,
    options: &RunOptions<'_>,
) -> Result<Surface, Error> {
    let dims = dims_of(&volume)?;
    let grid = Grid::new(dims, crate::geom::Affine::IDENTITY);
    mesh_placed(volume, &grid, Space::Voxel, surface, options)
}

/// [`mesh`], placed: `grid` gives the volume's dimensions and millimetres, `space` the output's.
///
/// # Errors
/// As [`mesh`]; and where `f32` coordinates are too coarse for the place.
pub fn mesh_placed<T: Classify>(
    volume: ArrayView3<'_, T>,
    grid: &Grid,
    space: Space,
    surface: &SurfaceOptions,
    options: &RunOptions<'_>,
) -> Result<Surface, Error> {
    let dims = dims_of(&volume)?;
    if dims != grid.dims {
        return Err(Error::new(RunError::Internal("the grid is not that of the volume")));
    }
    let place = Place::new(grid, space).map_err(|e| Error::new(RunError::from(e)))?;
    let kernel = Kernel::new(dims, &place, Rescale::IDENTITY, surface.rule(), cpu());
    into_memory(volume, dims, &kernel, options).map_err(Error::new)
}

fn dims_of<T>(volume: &ArrayView3<'_, T>) -> Result<Dims, Error> {
    let (nz, ny, nx) = volume.dim();
    Dims::checked(nx as i64, ny as i64, nz as i64, size_of::<T>())
        .map_err(|e| Error::new(SourceError::from(e)))
}

fn into_memory<T: Classify>(
    volume: ArrayView3<'_, T>,
    dims: Dims,
    kernel: &Kernel<T>,
    options: &RunOptions<'_>,
) -> Result<Surface, RunError> {
    let most = most_possible(dims, kernel.most_a_cell());
    let reserved =
        Buffer::reserve(most.n_vertices as usize).zip(Buffer::reserve(most.n_triangles as usize));
    let (mut vertices, mut triangles) = if let Some(reserved) = reserved {
        reserved
    } else {
        let mut counter = Counter;
        let surfaces = vec![(kernel.clone(), &mut counter)];
        let totals = total(&run(Planes::Resident(volume), dims, surfaces, options)?);
        let n = |n: u64| n as usize;
        (Buffer::zeroed(n(totals.n_vertices)), Buffer::zeroed(n(totals.n_triangles)))
    };
    let mut output = InMemory { rest: Some((&mut vertices, &mut triangles)) };
    let surfaces = vec![(kernel.clone(), &mut output)];
    let totals = total(&run(Planes::Resident(volume), dims, surfaces, options)?);
    vertices.truncate(totals.n_vertices as usize);
    triangles.truncate(totals.n_triangles as usize);
    Ok(Surface { vertices, triangles })
}

fn total(outcome: &Outcome) -> Totals {
    outcome.totals.first().copied().unwrap_or_default()
}

/// No mesh of a volume of this size has more, and never more than the ids allow.
fn most_possible(dims: Dims, a_cell: Totals) -> Totals {
    let cells = dims.to_array().iter().map(|&n| n as u64 + 1).fold(1, u64::saturating_mul);
    Totals {
        n_vertices: cells.saturating_mul(a_cell.n_vertices).min(MAX_VERTICES),
        n_triangles: cells.saturating_mul(a_cell.n_triangles).min(MAX_TRIANGLES),
    }
}

/// Slices of the arrays, cut off in slab order.
struct InMemory<'m> {
    rest: Option<(&'m mut [Position], &'m mut [Triangle])>,
}

impl<'m, T: Classify> Output<T> for InMemory<'m> {
    type Claim = (&'m mut [Position], &'m mut [Triangle]);
    type Store = (&'m mut [Position], &'m mut [Triangle]);
    type Buffers = ();

    fn store(&mut self) -> Self::Store {
        self.rest.take().unwrap_or_default()
    }

    fn claim(store: &mut Self::Store, totals: Totals) -> Result<Self::Claim, RunError> {
        let (n_vertices, n_triangles) = (totals.n_vertices as usize, totals.n_triangles as usize);
        let (vertices, triangles) = std::mem::take(store);
        let short = RunError::Internal("more output than was counted");
        let Some((vertices, more_vertices)) = vertices.split_at_mut_checked(n_vertices) else {
            return Err(short);
        };
        let Some((triangles, more_triangles)) = triangles.split_at_mut_checked(n_triangles) else {
            return Err(short);
        };
        *store = (more_vertices, more_triangles);
        Ok((vertices, triangles))
    }

    fn put(
        &self,
        counted: Counted<'_, T>,
        (vertices, triangles): Self::Claim,
        (): &mut (),
        _: &Stop,
    ) -> Result<Spent, RunError> {
        let begun = std::time::Instant::now();
        let out = PatchSlices { ghosts: None, vertices, triangles };
        let layers = counted.slab.layers.clone();
        counted.kernel.fill(counted.slab, counted.scratch, layers, counted.first_vertex, out);
        Ok(Spent { mesh: begun.elapsed(), ..Spent::default() })
    }

    fn wake(&self) {}
}

/// Makes nothing: for the totals alone.
struct Counter;

impl<T: Classify> Output<T> for Counter {
    type Claim = ();
    type Store = ();
    type Buffers = ();

    fn store(&mut self) {}

    fn claim((): &mut (), _: Totals) -> Result<(), RunError> {
        Ok(())
    }

    fn put(&self, _: Counted<'_, T>, (): (), (): &mut (), _: &Stop) -> Result<Spent, RunError> {
        Ok(Spent::default())
    }

    fn wake(&self) {}
}
