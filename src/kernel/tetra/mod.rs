//! Marching tetrahedra: the same bit planes, layers and order, with the diagonals of Kuhn's split
//! numbered as well.
//!
//! A layer's vertices are those on its Z edges, its XZ, YZ and main diagonals, then those on the X
//! edges, the Y edges and the XY diagonals of the plane after it; each by (y, x) of the upper end.

mod edges;
mod emit;
mod normals;
mod tables;
mod vertices;

pub(super) use edges::{Crossings, Diagonals, Kind};
pub(super) use emit::TetraTriangles;
pub use tables::{N_TETRA_EDGES, TetraTables, edge_ends};
pub(super) use vertices::Between;

use super::key::Bits;
use super::normal::Surroundings;
use super::slab::LayerScratch;
use super::vertices::{LayerSlots, Plane, Slots};
use super::{Classify, Kernel, Slab, simd};
use crate::geom::vec3::{Vec3, add};
use crate::mesh::Position;

impl<T: Classify> Kernel<T> {
    /// Counts the crossed diagonals of a plane.
    pub(super) fn count_plane_diagonals(&self, bits: &mut Bits) {
        let Bits(plane, diagonals) = bits;
        simd::tetra::count(self.cpu, self.placing.region, Kind::XY, [plane, plane], diagonals);
    }

    /// Counts the crossed diagonals of layer `s`, between two planes.
    pub(super) fn count_diagonals(&self, s: usize, planes: [&Bits; 2], layer: &mut LayerScratch) {
        let Diagonals { xz, yz, body } = &mut layer.diagonals;
        let kinds = [(Kind::XZ, xz), (Kind::YZ, yz), (Kind::XY, body)];
        let in_border = s == 0 || s == self.dims.nz();
        for (kind, crossings) in kinds {
            if self.placing.region.has_layer(in_border) {
                let planes = planes.map(|bits| &bits.0);
                simd::tetra::count(self.cpu, self.placing.region, kind, planes, crossings);
            } else {
                crossings.clear(self.placing.dims.1);
            }
        }
    }

    /// Makes the vertices on the edges and diagonals of plane `k`.
    pub(super) fn tetra_ghosts(
        &self,
        k: usize,
        slab: &Slab<'_, T>,
        bits: &Bits,
        out: &mut [Position],
    ) {
        let plane = self.plane(k as i64, slab, &bits.0);
        let n_edges = plane.bits.n_x() as usize + plane.bits.n_y() as usize;
        let (edges, diagonals) = out.split_at_mut(n_edges);
        simd::ghosts(self.cpu, &self.placing, plane, edges);
        let out = Slots { positions: diagonals, normals: None };
        self.diagonals(Kind::XY, &bits.1, [plane; 2], None, None, out);
    }

    /// Makes the vertices of layer `s`, those of the plane after it included.
    pub(super) fn tetra_layer_vertices(
        &self,
        s: usize,
        slab: &Slab<'_, T>,
        bits: [&Bits; 2],
        layer: &LayerScratch,
        out: Slots<'_>,
    ) {
        let normals = out.normals.is_some();
        let edges = self.layer_edges(s, slab, bits.map(|bits| &bits.0), layer, normals);
        let around = edges.around.as_ref();
        let Diagonals { xz, yz, body } = &layer.diagonals;
        let (z, mut rest) = out.split_at(layer.cells.n_z() as usize);
        for (kind, crossings) in [(Kind::XZ, xz), (Kind::YZ, yz), (Kind::XY, body)] {
            let (own, others) = rest.split_at(crossings.total() as usize);
            rest = others;
            self.diagonals(kind, crossings, edges.planes, Some(edges.step), around, own);
        }
        let (x, rest) = rest.split_at(bits[1].0.n_x() as usize);
        let (y, xy) = rest.split_at(bits[1].0.n_y() as usize);
        simd::vertices(self.cpu, &edges, LayerSlots { z, x, y });
        self.diagonals(Kind::XY, &bits[1].1, [edges.planes[1]; 2], None, around, xy);
    }

    /// Makes the vertices on the diagonals of a kind: from one plane to another, a `step` on, or
    /// within one.
    fn diagonals(
        &self,
        kind: Kind,
        crossings: &Crossings,
        planes: [Plane<'_, T>; 2],
        step: Option<Vec3>,
        around: Option<&Surroundings<'_, T>>,
        out: Slots<'_>,
    ) {
        let dz = usize::from(step.is_some());
        let mut step = step.unwrap_or_default();
        if kind.dx == 1 {
            step = add(self.placing.step_i, step);
        }
        if kind.dy == 1 {
            step = add(self.placing.step_j, step);
        }
        let between = Between { kind, crossings, planes, dz, step };
        simd::tetra::vertices(self.cpu, &self.placing, &between, out.positions);
        if let (Some(around), Some(normals)) = (around, out.normals) {
            between.normals(&self.placing, around, normals);
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
            open: self.placing.region.open,
        };
        simd::tetra::emit(self.cpu, &job, out);
    }
}
