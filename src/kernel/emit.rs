//! Triangles: each active cell's vertex ids by a permutation of sixteen running ids.
//!
//! ```text
//! local id
//!       0..4   X edges of rows A, B, C, D (see `layer`): the next id of each row
//!       4  6   Y edges of the plane before, left and right of the cell; the left one is always
//!              the last one counted, so it needs no search
//!       5  7   Y edges of the plane after
//!       8  9   Z edges of row r - 1, left and right;  10 11  of row r
//!       12..15 vertices in the cell: three walls, 15 the centre
//! ```
//!
//! Say the next vertices along a row have the ids 40 (X edges of row A), 70 (Y edges of the plane
//! before) and 90 (Z edges of row r - 1), and a cell has only its corner 1 inside, so the case
//! `0b0000_0010`: it crosses the X edge 0, the right-hand Y edge 6 and the right-hand Z edge 9. The
//! running ids of those are 40, 70 and 90, and the tables make the triangle of them. Then each moves
//! on by one, `crossed[case]`, and with 6 and 9 the left-hand 4 and 8: in the next cell they stand at
//! 70 and 90, the vertices that are there on its left.

use super::bits::BitPlane;
use super::layer::Layer;
use super::tables::Tables;

/// For each local id of a cell, the id of its vertex: moved on from cell to cell of a row.
pub(super) type RunningIds = [u32; 16];

/// Ids of the first vertices around a layer.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstIds {
    /// X and Y vertices of the plane before.
    pub(super) x_prev: u32,
    pub(super) y_prev: u32,
    /// Z vertices of the layer.
    pub(super) z: u32,
    /// Vertices inside cells.
    pub(super) extra: u32,
    /// X and Y vertices of the plane after.
    pub(super) x_cur: u32,
    pub(super) y_cur: u32,
}

impl FirstIds {
    /// For a layer whose first vertex has the id `first`: those of the plane before are the last
    /// ones before it.
    pub(super) fn of([prev, cur]: [&BitPlane; 2], layer: &Layer, n_extra: u32, first: u32) -> Self {
        let y_prev = first.wrapping_sub(prev.n_y());
        let extra = first.wrapping_add(layer.n_z());
        let x_cur = extra.wrapping_add(n_extra);
        Self {
            x_prev: y_prev.wrapping_sub(prev.n_x()),
            y_prev,
            z: first,
            extra,
            x_cur,
            y_cur: x_cur.wrapping_add(cur.n_x()),
        }
    }

    /// The running ids at the beginning of a row of cells.
    #[inline(always)]
    pub(super) fn running_ids(
        &self,
        [prev, cur]: [&BitPlane; 2],
        layer: &Layer,
        row: usize,
        open: bool,
    ) -> RunningIds {
        let (above, here) = (row, row + 1);
        let mut y = [self.y_prev + prev.y_before(here), self.y_cur + cur.y_before(here)];
        let mut z = [self.z + layer.z_before(above), self.z + layer.z_before(here)];
        if open {
            // The first cell between samples has left edges that were no cell's right ones: they are
            // the first of the row, not the last before it.
            let first = |p: &BitPlane, q: usize| (p.row(q)[1] & 1) as u32;
            let (a, b) = (first(prev, above), first(prev, here));
            let (c, d) = (first(cur, above), first(cur, here));
            y = [y[0] + (a ^ b), y[1] + (c ^ d)];
            z = [z[0] + (a ^ c), z[1] + (b ^ d)];
        }
        let left = |id: u32| id.wrapping_sub(1);
        [
            self.x_prev + prev.x_before(above),
            self.x_prev + prev.x_before(here),
            self.x_cur + cur.x_before(above),
            self.x_cur + cur.x_before(here),
            left(y[0]),
            left(y[1]),
            y[0],
            y[1],
            left(z[0]),
            z[0],
            left(z[1]),
            z[1],
            0,
            0,
            0,
            0,
        ]
    }
}

/// An unsettled cell, settled: which row of the tables it takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct SettledCell {
    /// How many active cells of its row of cells come before it.
    pub(super) nth: u32,
    pub(super) row: u16,
    /// Vertices inside the cell.
    pub(super) n_extra: u8,
}

/// What emitting a layer's triangles needs.
#[derive(Clone, Copy)]
pub(super) struct Triangles<'a> {
    pub(super) tables: &'static Tables,
    pub(super) planes: [&'a BitPlane; 2],
    pub(super) layer: &'a Layer,
    /// One for each of the layer's unsettled cells, in order.
    pub(super) settled: &'a [SettledCell],
    pub(super) first: FirstIds,
    pub(super) open: bool,
}

impl Triangles<'_> {
    /// Writes the ids of all triangles of the layer, three each, to the front of `out`, whose
    /// length may go beyond: what stands there may be overwritten. `plain` emits a run of cells none
    /// of which is settled, moves the running ids on, and gives back how many ids it wrote; `block` writes
    /// the first `n` of up to sixteen ids, at a place in the output.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(super) fn emit_with(
        &self,
        out: &mut [u32],
        plain: impl Fn(&Tables, &mut RunningIds, &[u8], &mut [u32]) -> usize,
        block: impl Fn(&RunningIds, [u8; 16], usize, usize, &mut [u32]),
    ) {
        let mut out = out;
        let mut cases = self.layer.cases();
        let mut settled = self.settled;
        let mut extra = self.first.extra;
        for run in &self.layer.rows {
            let mut ids =
                self.first.running_ids(self.planes, self.layer, run.row as usize, self.open);
            let (row, others) = cases.split_at(run.n_cells as usize);
            cases = others;
            let (cells, others) = settled.split_at(run.n_unsettled as usize);
            settled = others;
            let mut done = 0;
            for cell in cells {
                let (before, case) = (&row[done..cell.nth as usize], row[cell.nth as usize]);
                let n = plain(self.tables, &mut ids, before, out);
                out = &mut out[n..];
                if cell.n_extra > 0 {
                    // Walls or a centre, never both: they may have the same ids.
                    for (local, offset) in [(12, 0), (13, 1), (14, 2), (15, 0)] {
                        ids[local] = extra.wrapping_add(offset);
                    }
                    extra = extra.wrapping_add(u32::from(cell.n_extra));
                }
                let row = &self.tables.rows[usize::from(cell.row)];
                let n = 3 * usize::from(row.n_triangles);
                for (&locals, first) in row.ids.iter().zip([0, 16, 32]) {
                    if first < n {
                        block(&ids, locals, (n - first).min(16), first, out);
                    }
                }
                out = &mut out[n..];
                advance(&mut ids, &self.tables.crossed[usize::from(case)]);
                done = cell.nth as usize + 1;
            }
            let n = plain(self.tables, &mut ids, &row[done..], out);
            out = &mut out[n..];
        }
    }

    /// The definition of what every instruction set does.
    #[inline(always)]
    pub(super) fn emit_portable(&self, out: &mut [u32]) {
        self.emit_with(out, plain_cells, |ids, locals, n, at, out| {
            for (id, local) in out[at..at + n].iter_mut().zip(locals) {
                *id = ids[usize::from(local & 15)];
            }
        });
    }
}

#[inline(always)]
fn plain_cells(tables: &Tables, ids: &mut RunningIds, cases: &[u8], out: &mut [u32]) -> usize {
    let mut at = 0;
    for &case in cases {
        let case = usize::from(case);
        let n = 3 * usize::from(tables.n_triangles[case]);
        for (id, local) in out[at..at + n].iter_mut().zip(tables.ids[case]) {
            *id = ids[usize::from(local & 15)];
        }
        at += n;
        advance(ids, &tables.crossed[case]);
    }
    at
}

#[inline(always)]
fn advance(ids: &mut RunningIds, crossed: &[u8; 16]) {
    for (id, &by) in ids.iter_mut().zip(crossed) {
        *id = id.wrapping_add(u32::from(by));
    }
}
