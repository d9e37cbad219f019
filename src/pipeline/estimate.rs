//! What a run will take, said before it begins: memory, and roughly how many triangles.
//!
//! For dividing a machine among runs. Nothing here changes a mesh.

use super::RunOptions;
use super::patches::{BATCH_TRIANGLES, PATCH_TRIANGLES};
use super::plan::Plan;
use crate::geom::Dims;
use crate::kernel::{Method, Scratch};

/// A run's own part: its threads, its buffers for reading and writing, the counts of a survey.
const BASE_BYTES: u64 = 8 << 20;

/// A triangle of a patch: its ids, and half a vertex with its normal.
const TRIANGLE_BYTES: u64 = 12 + 12;

/// The lines of a triangle in an OBJ file with normals, the longest there are, in a buffer that may
/// have grown to twice what is in it.
const ENCODED_BYTES: u64 = 2 * 96;

/// Bytes that a run takes, thought of as all threads at work on slabs of `sample_bytes` samples whose
/// surfaces fill them: planes, bits and cases, patches, and `spooled` bytes a surface that wait in
/// memory for the end of the file. No scan of a body takes more, one that is cut off flat included; a
/// single layer of noise can have more triangles than a patch is meant for.
pub fn working_bytes(
    dims: Dims,
    sample_bytes: usize,
    method: Method,
    n_surfaces: usize,
    spooled: u64,
    options: &RunOptions<'_>,
) -> u64 {
    let threads = options.threads.max(1);
    let plan = Plan::new(dims, sample_bytes, threads, options.slab_planes, 1);
    let slabs = threads.min(plan.n_slabs()) as u64;
    let n_layers = plan.layers(0).len();
    let planes = slabs.saturating_mul(n_layers as u64 + 3);
    let samples = planes.saturating_mul(dims.plane_len() as u64);
    let scratch = Scratch::likely_bytes(dims.nx(), dims.ny(), n_layers, method);
    let patch = patch_bytes(dims, n_layers as u64, method);
    let per_surface = slabs.saturating_mul(scratch.saturating_add(patch)).saturating_add(spooled);
    BASE_BYTES
        .saturating_add(samples.saturating_mul(sample_bytes.max(1) as u64))
        .saturating_add(per_surface.saturating_mul(n_surfaces as u64))
}

/// A patch has one layer at least: the flat one that closes a body has two triangles a cell, eight of
/// tetrahedra. No cell of a body has more than five, or twelve.
fn patch_bytes(dims: Dims, n_layers: u64, method: Method) -> u64 {
    let (flat, most) = match method {
        Method::Cubes => (2, 5),
        Method::Tetrahedra => (8, 12),
    };
    let cells = (dims.nx() as u64 + 1).saturating_mul(dims.ny() as u64 + 1);
    let triangles = cells
        .saturating_mul(flat)
        .max(PATCH_TRIANGLES)
        .min(cells.saturating_mul(n_layers).saturating_mul(most));
    let encoded = triangles.min(BATCH_TRIANGLES as u64);
    triangles.saturating_mul(TRIANGLE_BYTES).saturating_add(encoded * ENCODED_BYTES)
}

/// Triangles that the surface of a body may have: six for each sample of the volume's three faces,
/// which is what heads and trunks come to within a factor of a few. Noise has far more.
pub fn likely_triangles(dims: Dims) -> u64 {
    let [nx, ny, nz] = dims.to_array().map(|n| n as u64);
    (nx * ny + ny * nz + nz * nx).saturating_mul(6)
}
