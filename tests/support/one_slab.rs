//! A volume in memory as one slab, straight through the kernel: no pipeline cuts or orders anything.

use mcubes::kernel::{Classify, Kernel, PatchSlices, Scratch, Slab};
use mcubes::mesh::Mesh;
use ndarray::ArrayView3;

/// The mesh, with normals where they are wanted.
pub(crate) fn one_slab<T: Classify>(
    volume: ArrayView3<'_, T>,
    kernel: &Kernel<T>,
    with_normals: bool,
) -> Mesh {
    let (nz, ny, nx) = volume.dim();
    let samples = volume.as_slice().unwrap();
    let planes: Vec<&[T]> = samples.chunks_exact(nx * ny).collect();
    let slab = Slab { layers: 0..nz + 1, first_plane: 0, planes: &planes };
    let mut scratch = Scratch::default();
    kernel.classify(&slab, &mut scratch);
    let totals = kernel.count(&slab, &mut scratch);
    let n_vertices = totals.n_vertices as usize;
    let mut mesh = Mesh {
        vertices: vec![[0.0; 3]; n_vertices],
        normals: vec![[0.0; 3]; if with_normals { n_vertices } else { 0 }],
        triangles: vec![[0; 3]; totals.n_triangles as usize],
    };
    let out = PatchSlices {
        ghosts: None,
        vertices: &mut mesh.vertices,
        normals: with_normals.then_some(&mut mesh.normals[..]),
        triangles: &mut mesh.triangles,
    };
    kernel.fill(&slab, &scratch, 0..nz + 1, 0, out);
    mesh
}
