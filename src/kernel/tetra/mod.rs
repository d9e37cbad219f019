//! Marching tetrahedra: the same bit planes, layers and order, with the diagonals of Kuhn's split
//! numbered as well.
//!
//! A layer's vertices are those on its Z edges, its XZ, YZ and main diagonals, then those on the X
//! edges, the Y edges and the XY diagonals of the plane after it; each by (y, x) of the upper end.

mod edges;
mod emit;
mod tables;
mod vertices;

pub(super) use edges::{Crossings, Diagonals, Kind, Region};
pub(super) use emit::TetraTriangles;
pub use tables::{N_LANES, TetraTables, lane_corners};
pub(super) use vertices::Between;

use super::key::Bits;
use super::slab::LayerScratch;
use super::{Classify, Kernel, Slab, simd};
use crate::geom::vec3::add;
use crate::mesh::Position;

impl<T: Classify> Kernel<T> {
    fn region(&self) -> Region {
        Region { dims: self.placing.dims, open: self.placing.open }
    }

    /// Counts the crossed diagonals of a plane.
    pub(super) fn count_plane_diagonals(&self, bits: &mut Bits) {
        let Bits(plane, diagonals) = bits;
        simd::tetra::count(self.cpu, &self.region(), Kind::XY, [plane, plane], diagonals);
    }

    /// Counts the crossed diagonals of layer `s`, between two planes.
    pub(super) fn count_diagonals(&self, s: usize, planes: [&Bits; 2], layer: &mut LayerScratch) {
        let Diagonals { xz, yz, body } = &mut layer.diagonals;
        let kinds = [(Kind::XZ, xz), (Kind::YZ, yz), (Kind::XY, body)];
        let in_border = s == 0 || s == self.dims.nz();
        for (kind, crossings) in kinds {
            if self.placing.open && in_border {
                crossings.clear(self.placing.dims.1);
            } else {
                let planes = planes.map(|bits| &bits.0);
                simd::tetra::count(self.cpu, &self.region(), kind, planes, crossings);
            }
        }
    }

    /// Makes the vertices on the edges and diagonals of plane `k`.
    pub(super) fn tetra_plane_vertices(
        &self,
        k: usize,
        bits: &Bits,
        samples: &[T],
        out: &mut [Position],
    ) {
        let Bits(plane, diagonals) = bits;
        let origin = self.place.plane_origin(k as i64);
        let n_edges = plane.n_x() as usize + plane.n_y() as usize;
        let (edges, rest) = out.split_at_mut(n_edges);
        simd::plane_vertices(self.cpu, &self.placing, plane, samples, origin, edges);
        let between = Between {
            kind: Kind::XY,
            crossings: diagonals,
            bits: [plane, plane],
            samples: [Some(samples); 2],
            origin,
            step: add(self.placing.step_i, self.placing.step_j),
        };
        simd::tetra::vertices(self.cpu, &self.placing, &between, rest);
    }

    /// Makes the vertices of layer `s`, those of the plane after it included.
    pub(super) fn tetra_layer_vertices(
        &self,
        s: usize,
        slab: &Slab<'_, T>,
        planes: [&Bits; 2],
        layer: &LayerScratch,
        out: &mut [Position],
    ) {
        let (z, mut rest) = out.split_at_mut(layer.cells.n_z() as usize);
        let before = s as i64 - 1;
        let samples = [s.checked_sub(1).and_then(|k| slab.plane(k)), slab.plane(s)];
        let (origin, step_k) = (self.place.plane_origin(before), self.place.step_k(before));
        let bits = planes.map(|bits| &bits.0);
        simd::z_vertices(self.cpu, &self.placing, bits, samples, (origin, step_k), z);
        let (step_i, step_j) = (self.placing.step_i, self.placing.step_j);
        let Diagonals { xz, yz, body } = &layer.diagonals;
        for (kind, crossings, across) in
            [(Kind::XZ, xz, step_i), (Kind::YZ, yz, step_j), (Kind::XY, body, add(step_i, step_j))]
        {
            let (own, others) = rest.split_at_mut(crossings.total() as usize);
            rest = others;
            let step = add(across, step_k);
            let between = Between { kind, crossings, bits, samples, origin, step };
            simd::tetra::vertices(self.cpu, &self.placing, &between, own);
        }
        if let Some(samples) = samples[1] {
            self.tetra_plane_vertices(s, planes[1], samples, rest);
        }
    }

    /// Writes the triangles of a layer whose first vertex has the id `first`.
    pub(super) fn tetra_triangles(
        &self,
        tables: &'static TetraTables,
        planes: [&Bits; 2],
        layer: &LayerScratch,
        first: u32,
        out: &mut [u32],
    ) {
        let job = TetraTriangles {
            tables,
            planes: planes.map(|bits| &bits.0),
            xy: planes.map(|bits| &bits.1),
            layer: &layer.cells,
            diagonals: &layer.diagonals,
            first,
            open: self.placing.open,
        };
        simd::tetra::emit(self.cpu, &job, out);
    }
}
