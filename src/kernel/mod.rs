//! From samples to triangles: bit planes, cases, vertices, triangles of one slab.
//!
//! ```text
//! plane of samples ─► bits ─► active cells, cases ─► settled cells ─► vertices ─► triangles
//!    key, cut         bits          layer             settle, cell     vertices      emit
//!                                                    decide, extra   gather, family
//!                                                                       crossing
//! ```
//!
//! `tables` lists every surface that a cell can have; `normal` makes the normals, `tetra` is the
//! method of tetrahedra, with the same steps; `simd` has the loops of each step, one file for each
//! instruction set.
//!
//! [`Kernel::count`] says how many vertices and triangles a slab has, [`Kernel::fill`] makes them
//! at the ids they have in the whole mesh. Pure: knows nothing of files, threads or clocks.

mod bits;
mod cell;
mod cpu;
mod crossing;
mod cut;
mod decide;
mod emit;
mod extra;
mod family;
mod gather;
mod key;
mod layer;
#[cfg(test)]
mod naive;
mod normal;
mod region;
mod settle;
mod simd;
mod slab;
mod tables;
mod tetra;
mod vertices;

pub use cell::{CellSurface, settle};
pub use cpu::{Cpu, cpu};
pub use crossing::crossing;
use cut::Cut;
pub use key::Classify;
pub(crate) use slab::SharedPlane;
pub use slab::{PatchSlices, Scratch, Slab, Totals};
pub use tables::{Row, Tables, cube};
pub use tetra::{N_TETRA_EDGES, TetraTables, edge_ends};

use std::ops::Range;

use crate::geom::{Dims, Place};
use crate::volume::{Rescale, Side};
use bits::BitPlane;
use cpu::Detected;
use emit::{FirstIds, Triangles};
use key::{Bits, Key, Threshold};
use layer::{Cells, Counts, UNSETTLED};
use region::Region;
use vertices::{LayerEdges, LayerSlots, Placing, Plane, Slots};

/// The surface of one volume at one iso value, slab by slab.
///
/// Layers of cells count from 0, between the border and plane 0, to `nz`, between the last plane
/// and the border: layer s lies between the planes s - 1 and s. A layer's vertices are those on its
/// Z edges, those inside its cells, then those on the X and the Y edges of plane s; each by (y, x).
#[derive(Clone)]
pub struct Kernel<T: Classify> {
    dims: Dims,
    threshold: Option<Threshold<T::Key>>,
    /// 1 where values rise from the iso value into the inside, else -1.
    sign: f64,
    place: Place,
    placing: Placing,
    tables: &'static Tables,
    /// Where the method is tetrahedra.
    tetra: Option<&'static TetraTables>,
    counts: Counts,
    cpu: Detected,
}

/// How cells become triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Marching cubes: the topology of the trilinear interpolant.
    #[default]
    Cubes,
    /// Marching tetrahedra, six a cell along its main diagonal: the topology of the interpolant
    /// that is linear in each.
    Tetrahedra,
}

impl Method {
    /// The word on the command line and in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Cubes => "cubes",
            Self::Tetrahedra => "tetrahedra",
        }
    }
}

/// What a surface is, apart from the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// The level in real units; finite.
    pub iso: f64,
    /// The side of it that is inside.
    pub side: Side,
    /// How cells become triangles.
    pub method: Method,
    /// Leaves out the cells of the border, and with them the cap.
    pub open: bool,
}

impl<T: Classify> Kernel<T> {
    /// For samples on a grid of `dims` placed by `place`, whose real values `rescale` gives. `cpu`
    /// is lowered to what this processor has.
    pub fn new(dims: Dims, place: &Place, rescale: Rescale, rule: Rule, cpu: Cpu) -> Self {
        let cut = Cut::<T>::new(rescale, rule.iso, rule.side);
        let has_cells = !rule.open || dims.to_array().into_iter().all(|n| n > 1);
        let tables = Tables::get(place.is_reversed());
        let tetra =
            (rule.method == Method::Tetrahedra).then(|| TetraTables::get(place.is_reversed()));
        let counts = match tetra {
            Some(tetra) => tetra.n_triangles,
            None => std::array::from_fn(|case| {
                if tables.is_unsettled[case] { UNSETTLED } else { tables.n_triangles[case] }
            }),
        };
        Self {
            dims,
            threshold: Threshold::of(cut).filter(|_| has_cells),
            sign: if matches!(cut, Cut::UpTo(_)) { -1.0 } else { 1.0 },
            placing: Placing {
                step_i: place.step_i(),
                step_j: place.step_j(),
                level: rescale.level(rule.iso),
                epsilon: place.epsilon(),
                dims: (dims.nx(), dims.ny()),
                region: Region { dims: (dims.nx(), dims.ny()), open: rule.open },
            },
            place: place.clone(),
            tables,
            tetra,
            counts,
            cpu: Detected::at_most(cpu),
        }
    }

    /// No mesh has more for each cell, the border's included: its edges (those at its lowest corner)
    /// and vertices inside it, and triangles.
    pub fn most_a_cell(&self) -> Totals {
        match self.tetra {
            Some(_) => Totals { n_vertices: 7, n_triangles: 12 },
            None => Totals { n_vertices: 6, n_triangles: 16 },
        }
    }

    /// Turns the planes after each of the slab's layers into bits; [`Kernel::count`] does so with the
    /// one before them all, if `scratch` does not have it by then. `scratch` is of this kernel alone.
    pub fn classify(&self, slab: &Slab<'_, T>, scratch: &mut Scratch) {
        let (nx, ny) = self.placing.dims;
        let n_layers = slab.layers.len();
        scratch.prepare(nx, ny, n_layers);
        scratch.keep_last_plane(slab.layers.start);
        for (bits, k) in scratch.bits.iter_mut().skip(1).zip(slab.layers.clone()) {
            self.classify_plane(Some(k), slab, bits);
        }
        scratch.remember(slab.layers.end, n_layers);
    }

    /// How many vertices and triangles a classified slab has. What was found stays in `scratch` for
    /// [`Kernel::fill`].
    pub fn count(&self, slab: &Slab<'_, T>, scratch: &mut Scratch) -> Totals {
        if scratch.lacks_first_plane()
            && let Some(first) = scratch.bits.first_mut()
        {
            self.classify_plane(slab.layers.start.checked_sub(1), slab, first);
        }
        let (nx, ny) = self.placing.dims;
        let mut totals = Totals::default();
        for (n, s) in slab.layers.clone().enumerate() {
            let (prev, cur, layer) = scratch.layer(n);
            if self.tetra.is_some() {
                self.count_diagonals(s, [prev, cur], layer);
            }
            let planes = [&prev.0, &cur.0];
            let cells =
                Cells { region: self.placing.region, in_border: s == 0 || s == self.dims.nz() };
            simd::fill_layer(self.cpu, &self.counts, planes, (nx, ny), cells, &mut layer.cells);
            let samples = [s.checked_sub(1).and_then(|k| slab.plane(k)), slab.plane(s)];
            layer.totals = Totals::default();
            layer.settled.clear();
            if !layer.cells.unsettled.is_empty() {
                self.settle(s, samples, layer);
            }
            let settled = &layer.settled;
            layer.totals = Totals {
                n_vertices: u64::from(layer.cells.n_z())
                    + settled.extra.len() as u64
                    + u64::from(cur.0.n_x())
                    + u64::from(cur.0.n_y())
                    + layer.diagonals.total()
                    + u64::from(cur.1.total()),
                n_triangles: layer.cells.n_plain_triangles + settled.n_triangles,
            };
            totals.n_vertices += layer.totals.n_vertices;
            totals.n_triangles += layer.totals.n_triangles;
        }
        totals
    }

    /// Makes the vertices and triangles of some of the layers last counted (`part`, numbered as the
    /// volume's layers are), the first vertex at the id `first_vertex`. The slices have just the
    /// lengths that the totals of those layers say.
    pub fn fill(
        &self,
        slab: &Slab<'_, T>,
        scratch: &Scratch,
        part: Range<usize>,
        first_vertex: u32,
        out: PatchSlices<'_>,
    ) {
        let mut vertices = Slots { positions: out.vertices, normals: out.normals };
        let mut triangles: &mut [u32] = out.triangles.as_flattened_mut();
        let mut first = first_vertex;
        if let (Some(ghosts), Some(k)) = (out.ghosts, part.start.checked_sub(1)) {
            let bits = &scratch.bits[part.start - slab.layers.start];
            if self.tetra.is_some() {
                self.tetra_ghosts(k, slab, bits, ghosts);
            } else {
                let plane = self.plane(k as i64, slab, &bits.0);
                simd::ghosts(self.cpu, &self.placing, plane, ghosts);
            }
        }
        for s in part {
            let n = s - slab.layers.start;
            let bits = [&scratch.bits[n], &scratch.bits[n + 1]];
            let planes = bits.map(|bits| &bits.0);
            let layer = &scratch.layers[n];
            let (own, rest) = vertices.split_at(layer.totals.n_vertices as usize);
            vertices = rest;
            if let Some(tables) = self.tetra {
                self.tetra_layer_vertices(s, slab, bits, layer, own);
                self.tetra_triangles(tables, bits, layer, first, triangles);
            } else {
                self.layer_vertices(s, slab, planes, layer, own);
                let extra = layer.settled.extra.len() as u32;
                let job = Triangles {
                    tables: self.tables,
                    planes,
                    layer: &layer.cells,
                    settled: &layer.settled.cells,
                    first: FirstIds::of(planes, &layer.cells, extra, first),
                    open: self.placing.region.open,
                };
                simd::emit(self.cpu, &job, triangles);
            }
            triangles = &mut triangles[3 * layer.totals.n_triangles as usize..];
            first = first.wrapping_add(layer.totals.n_vertices as u32);
        }
    }

    /// Vertices of the plane before a layer: a patch's ghosts.
    pub fn n_ghosts(&self, slab: &Slab<'_, T>, scratch: &Scratch, layer: usize) -> usize {
        let Bits(bits, diagonals) = &scratch.bits[layer - slab.layers.start];
        bits.n_x() as usize + bits.n_y() as usize + diagonals.total() as usize
    }

    /// Makes the vertices of layer `s`, those of the plane after it included.
    fn layer_vertices(
        &self,
        s: usize,
        slab: &Slab<'_, T>,
        bits: [&BitPlane; 2],
        layer: &slab::LayerScratch,
        out: Slots<'_>,
    ) {
        let (z, rest) = out.split_at(layer.cells.n_z() as usize);
        let (extra, rest) = rest.split_at(layer.settled.extra.len());
        let (x, y) = rest.split_at(bits[1].n_x() as usize);
        let edges = self.layer_edges(s, slab, bits, layer, x.normals.is_some());
        simd::vertices(self.cpu, &edges, LayerSlots { z, x, y });
        extra.positions.copy_from_slice(&layer.settled.extra);
        if let Some(normals) = extra.normals
            && !normals.is_empty()
        {
            self.extra_normals(s, slab, layer, normals);
        }
    }

    /// The crossed grid edges of layer `s`; `normals` where normals are wanted.
    fn layer_edges<'a>(
        &'a self,
        s: usize,
        slab: &Slab<'a, T>,
        [before, after]: [&'a BitPlane; 2],
        layer: &'a slab::LayerScratch,
        normals: bool,
    ) -> LayerEdges<'a, T> {
        let k = s as i64;
        LayerEdges {
            placing: &self.placing,
            words: &layer.cells.words,
            planes: [self.plane(k - 1, slab, before), self.plane(k, slab, after)],
            step: self.place.step_k(k - 1),
            around: normals.then(|| self.surroundings(s, slab)),
        }
    }

    /// Plane `k`, the border included.
    fn plane<'a>(&self, k: i64, slab: &Slab<'a, T>, bits: &'a BitPlane) -> Plane<'a, T> {
        let samples = usize::try_from(k).ok().and_then(|k| slab.plane(k)).unwrap_or_default();
        Plane { bits, samples, origin: self.place.plane_origin(k) }
    }

    fn classify_plane(&self, k: Option<usize>, slab: &Slab<'_, T>, out: &mut Bits) {
        match (self.threshold, k.and_then(|k| slab.plane(k))) {
            (Some(threshold), Some(samples)) => {
                let keys = bytemuck::must_cast_slice::<T, T::Key>(samples);
                T::Key::fill(self.cpu, keys, threshold, self.placing.region, out);
            }
            _ => out.0.clear(),
        }
        if self.tetra.is_some() {
            self.count_plane_diagonals(out);
        }
    }
}
