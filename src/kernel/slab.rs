//! What goes into the kernel and what comes out of it.

use std::ops::Range;

use super::Method;
use super::bits::BitPlane;
use super::key::Bits;
use super::layer::{ActiveWord, Layer, RowRun};
use super::settle::Settled;
use super::tetra::{Crossings, Diagonals};
use crate::mesh::{Normal, Position, Triangle};

/// Consecutive layers of cells, with the samples of all planes that they touch.
#[derive(Clone, Debug)]
pub struct Slab<'a, T> {
    /// Which layers: `0..=nz` are all.
    pub layers: Range<usize>,
    /// The number of the first plane given.
    pub first_plane: usize,
    /// Samples of consecutive planes, `nx * ny` each, i fastest: those from `layers.start - 1` to
    /// `layers.end - 1` that the volume has, and perhaps more on either side.
    pub planes: &'a [&'a [T]],
}

impl<'a, T> Slab<'a, T> {
    /// The samples of plane `k`, if the volume has it.
    pub(super) fn plane(&self, k: usize) -> Option<&'a [T]> {
        self.planes.get(k.checked_sub(self.first_plane)?).copied()
    }
}

/// Numbers of vertices and triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Totals {
    pub n_vertices: u64,
    pub n_triangles: u64,
}

/// Where [`super::Kernel::fill`] writes.
#[derive(Debug)]
pub struct PatchSlices<'a> {
    /// Repeats the vertices of the plane before the first layer, where they are wanted.
    pub ghosts: Option<&'a mut [Position]>,
    /// The vertices of the layers.
    pub vertices: &'a mut [Position],
    /// One unit normal for each of `vertices`, where they are wanted. The slab then needs a plane
    /// more on either side, where the volume has one.
    pub normals: Option<&'a mut [Normal]>,
    /// Their triangles.
    pub triangles: &'a mut [Triangle],
}

/// What a worker of one kernel keeps from counting a slab to filling it, and reuses for the next.
#[derive(Debug, Default)]
pub struct Scratch {
    /// One bit plane more than layers.
    pub(super) bits: Vec<Bits>,
    pub(super) layers: Vec<LayerScratch>,
    /// The layer that begins at the plane whose bits stand at `last_bits`.
    next_layer: Option<usize>,
    last_bits: usize,
    /// Whether the bits of the plane before the slab's first layer are there.
    pub(super) has_first: bool,
}

/// The bits of a plane that two slabs share, on their way from one worker to another.
#[derive(Debug, Default)]
pub(crate) struct SharedPlane(Option<Bits>);

/// One layer of a slab.
#[derive(Debug, Default)]
pub(super) struct LayerScratch {
    pub(super) cells: Layer,
    pub(super) settled: Settled,
    /// Tetrahedra only.
    pub(super) diagonals: Diagonals,
    pub(super) totals: Totals,
}

impl Scratch {
    /// Bytes for slabs of `n_layers` layers of planes of `nx` by `ny` samples, with room for the
    /// active cells of a body, and for the plane that is shared with another worker.
    pub fn likely_bytes(nx: usize, ny: usize, n_layers: usize, method: Method) -> u64 {
        const CELLS_A_SAMPLE: u64 = 24;
        // One of the plane, and three between the planes.
        let diagonals = if method == Method::Tetrahedra { 4 } else { 0 };
        let a_row =
            size_of::<RowRun>() + size_of::<ActiveWord>() + (1 + diagonals) * size_of::<u32>();
        let rows = (ny as u64 + 3).saturating_mul(a_row as u64);
        let planes = BitPlane::bytes(nx, ny).saturating_mul(n_layers as u64 + 2);
        let cells = (nx as u64).saturating_mul(ny as u64).saturating_mul(CELLS_A_SAMPLE);
        planes.saturating_add(rows.saturating_mul(n_layers as u64)).saturating_add(cells)
    }

    /// The totals of the layer `n` of the slab last counted.
    pub fn totals(&self, n: usize) -> Totals {
        self.layers.get(n).map_or_else(Totals::default, |layer| layer.totals)
    }

    pub(super) fn prepare(&mut self, nx: usize, ny: usize, n_layers: usize) {
        while self.bits.len() < n_layers + 1 {
            self.bits.push(Bits(BitPlane::new(nx, ny), Crossings::default()));
        }
        while self.layers.len() < n_layers {
            self.layers.push(LayerScratch::default());
        }
    }

    /// Puts the bits of the plane before `layer` in front, if they are left over from the slab
    /// before.
    pub(super) fn keep_last_plane(&mut self, layer: usize) {
        self.has_first = self.next_layer.take() == Some(layer);
        if self.has_first {
            self.bits.swap(0, self.last_bits);
        }
    }

    /// Copies the bits of the last plane that [`super::Kernel::classify`] saw, for whoever counts
    /// the slab after this one.
    pub(crate) fn share_last_plane(&self, shared: &mut SharedPlane) {
        if let Some(last) = self.bits.get(self.last_bits) {
            shared.0.get_or_insert_with(Bits::empty).copy_from(last);
        }
    }

    /// Whether the slab's first layer still needs the bits of the plane before it.
    pub(crate) fn lacks_first_plane(&self) -> bool {
        !self.has_first
    }

    /// Takes the bits of the plane before the slab's first layer from whoever had that plane.
    pub(crate) fn take_first_plane(&mut self, shared: &mut SharedPlane) {
        if let (Some(theirs), Some(first)) = (&mut shared.0, self.bits.first_mut()) {
            std::mem::swap(first, theirs);
            self.has_first = true;
        }
    }

    /// Layer `n` of the slab, and the bits of the planes before and after it.
    pub(super) fn layer(&mut self, n: usize) -> (&mut Bits, &mut Bits, &mut LayerScratch) {
        let (before, after) = self.bits.split_at_mut(n + 1);
        (&mut before[n], &mut after[0], &mut self.layers[n])
    }

    pub(super) fn remember(&mut self, next_layer: usize, n_layers: usize) {
        self.next_layer = Some(next_layer);
        self.last_bits = n_layers;
    }
}
