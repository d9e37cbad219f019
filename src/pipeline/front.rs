//! The front door for a volume in memory: a mesh in memory, each patch made at its final place.

use ndarray::ArrayView3;

use super::run::{Counted, Outcome, Output, Spent, run};
use super::sequence::Stop;
use super::{RunError, RunOptions, SurfaceOptions};
use crate::error::Error;
use crate::geom::{Dims, Grid, Place, Space};
use crate::kernel::{Classify, Kernel, PatchSlices, Totals, cpu};
use crate::limits::{MAX_TRIANGLES, MAX_VERTICES};
use crate::mesh::{Buffer, Normal, Position, Triangle};
use crate::source::{Planes, SourceError};
use crate::volume::Rescale;

/// A mesh made in memory, in mappings of the system that nothing was copied into: a
/// [`Mesh`](crate::mesh::Mesh) is one in vectors.
#[derive(Debug)]
pub struct Surface {
    /// Positions in the output space.
    pub vertices: Buffer<Position>,
    /// One unit normal a vertex, pointing outward, where [`SurfaceOptions::normals`] asks for them.
    pub normals: Option<Buffer<Normal>>,
    /// Counter-clockwise seen from outside.
    pub triangles: Buffer<Triangle>,
}

/// Meshes a volume in memory: (z, y, x) order, x fastest; any strides, contiguous is fast.
///
/// Vertices are in voxel indices; [`mesh_placed`] puts them into millimetres. A volume in which
/// nothing reaches the iso value gives an empty mesh.
///
/// # Errors
/// A volume without samples or too large, an iso value that is no finite number, or a mesh of more
/// than 2³¹ - 1 vertices.
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
/// As [`mesh`]; a grid of other dimensions; and where `f32` coordinates are too coarse for the place.
pub fn mesh_placed<T: Classify>(
    volume: ArrayView3<'_, T>,
    grid: &Grid,
    space: Space,
    surface: &SurfaceOptions,
    options: &RunOptions<'_>,
) -> Result<Surface, Error> {
    let dims = dims_of(&volume)?;
    same(dims.to_array(), grid.dims).map_err(Error::new)?;
    let place = Place::new(grid, space).map_err(|e| Error::new(RunError::from(e)))?;
    let kernel =
        Kernel::new(dims, &place, Rescale::IDENTITY, surface.rule().map_err(Error::new)?, cpu());
    into_memory(volume, dims, &kernel, surface.normals, options).map_err(Error::new)
}

/// Whether a volume of `found` samples has the dimensions of the grid it is said to lie on.
pub(super) fn same(found: [usize; 3], grid: Dims) -> Result<(), RunError> {
    let expected = grid.to_array();
    if found == expected { Ok(()) } else { Err(RunError::Grid { found, expected }) }
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
    normals: bool,
    options: &RunOptions<'_>,
) -> Result<Surface, RunError> {
    let most = most_possible(dims, kernel.most_a_cell());
    let mut surface = if let Some(reserved) = Surface::reserve(most, normals) {
        reserved
    } else {
        let mut counter = Counter;
        let surfaces = vec![(kernel.clone(), &mut counter)];
        let totals = total(&run(Planes::Resident(volume), dims, surfaces, options)?);
        Surface::zeroed(totals, normals).ok_or_else(|| too_little_memory(totals, normals))?
    };
    let rest = Slices {
        vertices: &mut surface.vertices,
        normals: surface.normals.as_deref_mut(),
        triangles: &mut surface.triangles,
    };
    let mut output = InMemory { rest: Some(rest), normals };
    let surfaces = vec![(kernel.clone(), &mut output)];
    let totals = total(&run(Planes::Resident(volume), dims, surfaces, options)?);
    surface.truncate(totals);
    Ok(surface)
}

impl Surface {
    /// Room for the most there can be, if the system gives it.
    fn reserve(most: Totals, normals: bool) -> Option<Self> {
        let n_vertices = most.n_vertices as usize;
        Some(Self {
            vertices: Buffer::reserve(n_vertices)?,
            normals: if normals { Some(Buffer::reserve(n_vertices)?) } else { None },
            triangles: Buffer::reserve(most.n_triangles as usize)?,
        })
    }

    /// Room for just so many, in memory that is there.
    fn zeroed(totals: Totals, normals: bool) -> Option<Self> {
        let n_vertices = totals.n_vertices as usize;
        Some(Self {
            vertices: Buffer::zeroed(n_vertices)?,
            normals: if normals { Some(Buffer::zeroed(n_vertices)?) } else { None },
            triangles: Buffer::zeroed(totals.n_triangles as usize)?,
        })
    }

    fn truncate(&mut self, totals: Totals) {
        self.vertices.truncate(totals.n_vertices as usize);
        if let Some(normals) = &mut self.normals {
            normals.truncate(totals.n_vertices as usize);
        }
        self.triangles.truncate(totals.n_triangles as usize);
    }
}

fn too_little_memory(totals: Totals, normals: bool) -> RunError {
    let a_vertex = size_of::<Position>() + if normals { size_of::<Normal>() } else { 0 };
    let bytes =
        totals.n_vertices * a_vertex as u64 + totals.n_triangles * size_of::<Triangle>() as u64;
    RunError::Memory { bytes }
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

/// The arrays, or what is left of them.
#[derive(Default)]
struct Slices<'m> {
    vertices: &'m mut [Position],
    normals: Option<&'m mut [Normal]>,
    triangles: &'m mut [Triangle],
}

/// Slices of the arrays, cut off in slab order.
struct InMemory<'m> {
    rest: Option<Slices<'m>>,
    normals: bool,
}

impl<'m, T: Classify> Output<T> for InMemory<'m> {
    type Claim = Slices<'m>;
    type Store = Slices<'m>;
    type Buffers = ();

    fn halo(&self) -> usize {
        usize::from(self.normals)
    }

    fn store(&mut self) -> Self::Store {
        self.rest.take().unwrap_or_default()
    }

    fn claim(store: &mut Self::Store, totals: Totals) -> Result<Self::Claim, RunError> {
        let (n_vertices, n_triangles) = (totals.n_vertices as usize, totals.n_triangles as usize);
        let all = std::mem::take(store);
        let cut = || {
            let (vertices, more_vertices) = all.vertices.split_at_mut_checked(n_vertices)?;
            let (triangles, more_triangles) = all.triangles.split_at_mut_checked(n_triangles)?;
            let (normals, more_normals) = match all.normals {
                Some(normals) => {
                    let (normals, more) = normals.split_at_mut_checked(n_vertices)?;
                    (Some(normals), Some(more))
                }
                None => (None, None),
            };
            let rest = Slices {
                vertices: more_vertices,
                normals: more_normals,
                triangles: more_triangles,
            };
            Some((Slices { vertices, normals, triangles }, rest))
        };
        let (claim, rest) = cut().ok_or(RunError::Internal("more output than was counted"))?;
        *store = rest;
        Ok(claim)
    }

    fn put(
        &self,
        counted: Counted<'_, T>,
        Slices { vertices, normals, triangles }: Self::Claim,
        (): &mut (),
        _: &Stop,
    ) -> Result<Spent, RunError> {
        let begun = std::time::Instant::now();
        let out = PatchSlices { ghosts: None, vertices, normals, triangles };
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
