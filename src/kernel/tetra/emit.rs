//! Triangles: each active cell's vertex ids by a permutation of nineteen running ids.

use super::super::bits::BitPlane;
use super::super::emit::FirstIds;
use super::super::layer::Layer;
use super::edges::{Crossings, Diagonals};
use super::tables::TetraTables;

/// For each local id of `tables`, the id of its vertex, filled up to two registers.
pub(in super::super) type TetraRunningIds = [u32; 32];

/// What emitting a layer's triangles needs.
#[derive(Clone, Copy)]
pub(in super::super) struct TetraTriangles<'a> {
    pub(super) tables: &'static TetraTables,
    pub(super) planes: [&'a BitPlane; 2],
    /// The diagonals in the two planes.
    pub(super) xy: [&'a Crossings; 2],
    pub(super) layer: &'a Layer,
    pub(super) diagonals: &'a Diagonals,
    /// The id of the layer's first vertex.
    pub(super) first: u32,
    pub(super) open: bool,
}

/// Ids of the first vertices around a layer.
#[derive(Clone, Copy)]
struct Ids {
    edges: FirstIds,
    xy: [u32; 2],
    xz: u32,
    yz: u32,
    body: u32,
}

impl TetraTriangles<'_> {
    /// The vertices of the plane before are the last ones before the layer's.
    fn ids(&self) -> Ids {
        let [prev, cur] = self.planes;
        let xy_prev = self.first.wrapping_sub(self.xy[0].total());
        let y_prev = xy_prev.wrapping_sub(prev.n_y());
        let xz = self.first.wrapping_add(self.layer.n_z());
        let yz = xz.wrapping_add(self.diagonals.xz.total());
        let body = yz.wrapping_add(self.diagonals.yz.total());
        let x_cur = body.wrapping_add(self.diagonals.body.total());
        let y_cur = x_cur.wrapping_add(cur.n_x());
        let x_prev = y_prev.wrapping_sub(prev.n_x());
        Ids {
            edges: FirstIds { x_prev, y_prev, z: self.first, extra: 0, x_cur, y_cur },
            xy: [xy_prev, y_cur.wrapping_add(cur.n_y())],
            xz,
            yz,
            body,
        }
    }

    /// The running ids at the beginning of a row of cells.
    #[inline(always)]
    fn running_ids(&self, first: &Ids, row: usize) -> TetraRunningIds {
        let (above, here) = (row, row + 1);
        let mut running = [0; 32];
        let edges = first.edges.running_ids(self.planes, self.layer, row, self.open);
        running[..12].copy_from_slice(&edges[..12]);
        let mut yz = first.yz.wrapping_add(self.diagonals.yz.before(here));
        if self.open {
            // The first cell's left diagonal is never some cell's right one.
            yz += ((self.planes[0].row(above)[1] ^ self.planes[1].row(here)[1]) & 1) as u32;
        }
        running[12] = first.xy[0].wrapping_add(self.xy[0].before(here));
        running[13] = first.xy[1].wrapping_add(self.xy[1].before(here));
        running[14] = first.xz.wrapping_add(self.diagonals.xz.before(above));
        running[15] = first.xz.wrapping_add(self.diagonals.xz.before(here));
        running[16] = yz.wrapping_sub(1);
        running[17] = yz;
        running[18] = first.body.wrapping_add(self.diagonals.body.before(here));
        running
    }

    /// Writes the ids of all triangles of the layer, three each, to the front of `out`, whose length
    /// may go beyond: what stands there may be overwritten. `emit_row` does a row of cells and gives
    /// back how many ids it wrote.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(in super::super) fn emit_with(
        &self,
        out: &mut [u32],
        emit_row: impl Fn(&TetraTables, TetraRunningIds, &[u8], &mut [u32]) -> usize,
    ) {
        let ids = self.ids();
        let mut out = out;
        let mut cases = self.layer.cases();
        for run in &self.layer.rows {
            let (row, rest) = cases.split_at(run.n_cells as usize);
            cases = rest;
            let running = self.running_ids(&ids, run.row as usize);
            let n = emit_row(self.tables, running, row, out);
            out = &mut out[n..];
        }
    }

    /// The definition of what every instruction set does.
    #[inline(always)]
    pub(in super::super) fn emit_portable(&self, out: &mut [u32]) {
        self.emit_with(out, |tables, running, cases, out| {
            let mut ids = running;
            let mut at = 0;
            for &case in cases {
                let case = usize::from(case);
                let n = 3 * usize::from(tables.n_triangles[case]);
                let locals = tables.ids[case].as_flattened();
                for (id, local) in out[at..at + n].iter_mut().zip(locals) {
                    *id = ids[usize::from(local & 31)];
                }
                at += n;
                for (id, &by) in ids.iter_mut().zip(&tables.crossed[case]) {
                    *id = id.wrapping_add(u32::from(by));
                }
            }
            at
        });
    }
}
