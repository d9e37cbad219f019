//! What a run will take, said before it begins: memory, and roughly how many triangles.
//!
//! For dividing a machine among runs. Nothing here changes a mesh.

use super::RunOptions;
use super::patches::PATCH_TRIANGLES;
use super::plan::Plan;
use crate::geom::Dims;
use crate::kernel::Scratch;

/// A run's own part: its threads, its buffers for reading and writing, the counts of a survey.
const BASE_BYTES: u64 = 8 << 20;

/// Triangles of one slab of one surface that are held at once: a patch, and as many again that are
/// encoded.
const HELD_TRIANGLES: u64 = 2 * PATCH_TRIANGLES;

/// A triangle of a patch: its ids, half a vertex with its normal, and the lines of an OBJ file with
/// normals, the longest there are.
const TRIANGLE_BYTES: u64 = 12 + 12 + 96;

/// Bytes that a run takes, thought of as all threads at work on slabs of `sample_bytes` samples whose
/// surfaces fill them: planes, bits and cases, patches, and `spooled` bytes a surface that wait in
/// memory for the end of the file. No scan of a body takes more; a single layer of noise can have
/// more triangles than a patch is meant for.
pub fn working_bytes(
    dims: Dims,
    sample_bytes: usize,
    n_surfaces: usize,
    spooled: u64,
    options: &RunOptions<'_>,
) -> u64 {
    let threads = options.threads.max(1);
    let plan = Plan::new(dims, sample_bytes, threads, options.slab_planes, 1);
    let plane = dims.plane_len() as u64;
    let slabs = threads.min(plan.n_slabs()) as u64;
    let planes = plan.layers(0).len() as u64 + 3;
    let samples = slabs.saturating_mul(planes).saturating_mul(plane);
    let n_layers = plan.layers(0).len();
    let scratch = Scratch::likely_bytes(dims.nx(), dims.ny(), n_layers);
    let cells = (plane + 1).saturating_mul(n_layers as u64);
    let per_surface =
        slabs.saturating_mul(scratch.saturating_add(patch_bytes(cells))).saturating_add(spooled);
    BASE_BYTES
        .saturating_add(samples.saturating_mul(sample_bytes.max(1) as u64))
        .saturating_add(per_surface.saturating_mul(n_surfaces as u64))
}

/// A cell of tetrahedra has twelve triangles at most; of cubes five, but for the few that tunnels
/// add.
fn patch_bytes(cells: u64) -> u64 {
    cells.saturating_mul(12).min(HELD_TRIANGLES) * TRIANGLE_BYTES
}

/// Triangles that the surface of a body may have: six for each sample of the volume's three faces,
/// which is what heads and trunks come to within a factor of a few. Noise has far more.
pub fn likely_triangles(dims: Dims) -> u64 {
    let [nx, ny, nz] = dims.to_array().map(|n| n as u64);
    (nx * ny + ny * nz + nz * nx).saturating_mul(6)
}
