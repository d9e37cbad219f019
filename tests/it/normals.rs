//! Normals: those of the formula on smooth shapes, by the definition on any samples, always of
//! length 1 and outward, and the same bytes however the work is cut.

mod definition;
mod formulas;
mod order;

use mcubes::geom::{Affine, Dims, Grid, Place, Space};
use mcubes::kernel::{Classify, Cpu, Kernel, Rule};
use mcubes::mesh::{Normal, Position};
use mcubes::pipeline::{RunOptions, SurfaceOptions};
use mcubes::volume::Rescale;
use ndarray::ArrayView3;

use crate::support::one_slab::one_slab;

type Point = [f64; 3];

/// Vertices with their normals.
type Found = (Vec<Position>, Vec<Normal>);

fn dims_of<T>(volume: &ArrayView3<'_, T>) -> Dims {
    let (nz, ny, nx) = volume.dim();
    Dims::checked(nx as i64, ny as i64, nz as i64, 8).unwrap()
}

fn mesh_by<T: Classify>(
    volume: ArrayView3<'_, T>,
    (grid, space): (&Grid, Space),
    surface: &SurfaceOptions,
    threads: usize,
    slab_planes: Option<usize>,
) -> Found {
    let surface = SurfaceOptions { normals: true, ..*surface };
    let options = RunOptions { threads, slab_planes, ..RunOptions::default() };
    let mesh = mcubes::mesh_placed(volume, grid, space, &surface, &options).unwrap();
    (mesh.vertices.to_vec(), mesh.normals.unwrap().to_vec())
}

fn in_voxels<T: Classify>(volume: ArrayView3<'_, T>, surface: &SurfaceOptions) -> Found {
    let grid = Grid::new(dims_of(&volume), Affine::IDENTITY);
    mesh_by(volume, (&grid, Space::Voxel), surface, 1, None)
}

/// The whole volume as one slab.
fn by_kernel<T: Classify>(
    volume: ArrayView3<'_, T>,
    (grid, space): (&Grid, Space),
    rescale: Rescale,
    rule: Rule,
    cpu: Cpu,
) -> Found {
    let place = Place::new(grid, space).unwrap();
    let kernel = Kernel::new(grid.dims, &place, rescale, rule, cpu);
    let mesh = one_slab(volume, &kernel, true);
    (mesh.vertices, mesh.normals)
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: Point) -> Point {
    v.map(|x| x / dot(v, v).sqrt())
}

/// The angle between a normal and a direction, in radians: by the chord, since a cosine near 1
/// tells no small angle.
fn angle(normal: Normal, direction: Point) -> f64 {
    let (a, b) = (unit(normal.map(f64::from)), unit(direction));
    let chord = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    2.0 * (dot(chord, chord).sqrt() / 2.0).min(1.0).asin()
}

/// The same grid with other gaps between its planes, along the true line of its planes.
fn uneven(grid: &Grid, gap: impl Fn(i64) -> f64, aside: impl Fn(i64) -> f64) -> Grid {
    let nz = grid.dims.nz() as i64;
    let step = grid.affine.column(2);
    let mut at = -(0..nz).map(&gap).sum::<f64>() / 2.0 + (nz - 1) as f64 / 2.0;
    let mut origins = Vec::new();
    for k in 0..nz {
        let mut origin = [0, 1, 2].map(|a| grid.affine.column(3)[a] + at * step[a]);
        origin[0] += aside(k);
        origins.push(origin);
        at += gap(k);
    }
    Grid::uneven(grid.dims, grid.affine, origins)
}
