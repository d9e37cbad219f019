//! Normals at vertices on diagonals: as on grid edges, one after the other.

use super::super::normal::{Around, Surroundings};
use super::super::slab::LayerScratch;
use super::super::vertices::{LayerVertices, Placing, Plane};
use super::super::{Classify, Kernel, Slab};
use super::edges::{Crossings, Diagonals, Kind, Region};
use super::vertices::for_each_bit;
use crate::geom::vec3::Vec3;
use crate::kernel::key::Bits;
use crate::mesh::Normal;
use crate::volume::Sample;

impl<T: Classify> Kernel<T> {
    /// The normals of the vertices of layer `s`, in step with them. Needs a plane more on either
    /// side than the vertices do, where the volume has one.
    pub(in super::super) fn tetra_layer_normals(
        &self,
        s: usize,
        slab: &Slab<'_, T>,
        bits: [&Bits; 2],
        layer: &LayerScratch,
        out: &mut [Normal],
    ) {
        let k = s as i64;
        let planes = [self.plane(k - 1, slab, &bits[0].0), self.plane(k, slab, &bits[1].0)];
        let around = self.surroundings(s, slab);
        let Diagonals { xz, yz, body } = &layer.diagonals;
        let (z, mut rest) = out.split_at_mut(layer.cells.n_z() as usize);
        for (kind, crossings) in [(Kind::XZ, xz), (Kind::YZ, yz), (Kind::XY, body)] {
            let (own, others) = rest.split_at_mut(crossings.total() as usize);
            rest = others;
            let family = Family { kind, crossings, planes, dz: 1 };
            family.normals(&self.placing, &around, around.between.as_ref(), own);
        }
        let (x, rest) = rest.split_at_mut(bits[1].0.n_x() as usize);
        let (y, xy) = rest.split_at_mut(bits[1].0.n_y() as usize);
        let out = LayerVertices { z, x, y };
        self.edge_normals(s, slab, bits.map(|bits| &bits.0), layer, out);
        let family =
            Family { kind: Kind::XY, crossings: &bits[1].1, planes: [planes[1]; 2], dz: 0 };
        family.normals(&self.placing, &around, around.plane.as_ref(), xy);
    }
}

/// Diagonals of one kind from one plane to another, or within one plane.
struct Family<'a, T> {
    kind: Kind,
    crossings: &'a Crossings,
    /// The planes of the lower and the upper ends.
    planes: [Plane<'a, T>; 2],
    /// Planes from a lower to an upper end.
    dz: usize,
}

impl<T: Sample> Family<'_, T> {
    /// Makes the normals, by (y, x) of the upper end; `within` is for those between samples.
    fn normals(
        &self,
        placing: &Placing,
        around: &Surroundings<'_, T>,
        within: Option<&Around<'_, T>>,
        out: &mut [Normal],
    ) {
        let mut out = out.iter_mut();
        let Kind { dx, dy } = self.kind;
        let region = Region { dims: placing.dims, open: placing.open };
        let [low, high] = self.planes.map(|plane| plane.bits);
        let words = high.row_words();
        for q in region.rows(self.kind) {
            if self.crossings.before(q) == self.crossings.before(q + 1) {
                continue;
            }
            let (low, high) = (&low.row(q - dy)[..=words], &high.row(q)[..=words]);
            for w in 0..words {
                for_each_bit(region.crossed(self.kind, low, high, w), w * 64, |c| {
                    let beyond = self.beyond(placing.dims, c, q - 1);
                    let normal = match within {
                        Some(within) if beyond == [0.0; 3] => {
                            within.on_edge([c - dx, q - 1 - dy, 1], [c, q - 1, 1 + self.dz])
                        }
                        _ => around.cap(beyond),
                    };
                    if let Some(slot) = out.next() {
                        *slot = normal;
                    }
                });
            }
        }
    }

    /// On which sides of the volume a diagonal's outer end lies, along the grid's axes; on none if
    /// both ends are samples. `c` and `r` are those of the upper end.
    fn beyond(&self, (nx, ny): (usize, usize), c: usize, r: usize) -> Vec3 {
        let side = |is_before: bool, is_after: bool| f64::from(is_after) - f64::from(is_before);
        let Kind { dx, dy } = self.kind;
        let [is_before, is_after] = self.planes.map(|plane| plane.samples.is_empty());
        [side(c < dx, c >= nx), side(r < dy, r >= ny), side(is_before, is_after)]
    }
}
