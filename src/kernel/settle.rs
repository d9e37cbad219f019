//! Cells whose case alone does not say what their surface is.

use super::emit::SettledCell;
use super::slab::LayerScratch;
use super::tables::cube::{corner_at, edge_corners};
use super::vertices::Placing;
use super::{CellSurface, Classify, Kernel, crossing, settle};
use crate::geom::vec3::{add, scale};
use crate::mesh::Position;

/// What became of a layer's unsettled cells.
#[derive(Debug, Default)]
pub(super) struct Settled {
    /// One for each unsettled cell.
    pub(super) cells: Vec<SettledCell>,
    /// The vertices inside cells, placed.
    pub(super) extra: Vec<Position>,
    pub(super) n_triangles: u64,
}

impl Settled {
    pub(super) fn clear(&mut self) {
        self.cells.clear();
        self.extra.clear();
        self.n_triangles = 0;
    }
}

impl<T: Classify> Kernel<T> {
    /// Settles the unsettled cells of layer `s`, between two planes of samples.
    pub(super) fn settle(&self, s: usize, samples: [Option<&[T]>; 2], layer: &mut LayerScratch) {
        let LayerScratch { cells, settled, .. } = layer;
        let before = s as i64 - 1;
        let (origin, step_k) = (self.place.plane_origin(before), self.place.step_k(before));
        let mut unsettled = cells.unsettled.iter();
        for run in &cells.rows {
            if run.n_unsettled == 0 {
                continue;
            }
            let r = run.row as usize;
            let base = add(origin, scale(self.placing.step_j, r as f64 - 1.0));
            for cell in unsettled.by_ref().take(run.n_unsettled as usize) {
                let c = cell.c as usize;
                let corners = self.corners(samples, r, c);
                let surface = self.settle_cell(cell.case, &corners);
                let corner = add(base, scale(self.placing.step_i, f64::from(cell.c) - 1.0));
                for &[x, y, z] in &surface.extra[..surface.n_extra.into()] {
                    let within = add(scale(self.placing.step_i, x), scale(self.placing.step_j, y));
                    let place = add(add(corner, within), scale(step_k, z));
                    settled.extra.push(place.map(|x| x as f32));
                }
                let row = &self.tables.rows[usize::from(surface.row)];
                let CellSurface { row: number, n_extra, .. } = surface;
                settled.cells.push(SettledCell { nth: cell.nth, row: number, n_extra });
                settled.n_triangles += u64::from(row.n_triangles);
            }
        }
    }

    /// The samples at the corners of cell `c` of row `r`; NaN outside the volume, where no decider
    /// looks.
    pub(super) fn corners(&self, samples: [Option<&[T]>; 2], r: usize, c: usize) -> [f64; 8] {
        let (nx, ny) = self.placing.dims;
        if let [Some(before), Some(after)] = samples
            && (1..nx).contains(&c)
            && (1..ny).contains(&r)
        {
            let at = (r - 1) * nx + c - 1;
            let pair = |plane: &[T], at: usize| match plane.get(at..at + 2) {
                Some(&[left, right]) => [left.to_f64(), right.to_f64()],
                _ => [f64::NAN; 2],
            };
            let [a, b] = [pair(before, at), pair(before, at + nx)];
            let [c, d] = [pair(after, at), pair(after, at + nx)];
            return [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]];
        }
        std::array::from_fn(|corner| {
            let [x, y, z] = corner_at(corner);
            let (i, j) = ((c + x).wrapping_sub(1), (r + y).wrapping_sub(1));
            match samples[z] {
                Some(plane) if i < nx && j < ny => plane[j * nx + i].to_f64(),
                _ => f64::NAN,
            }
        })
    }

    pub(super) fn settle_cell(&self, case: u8, samples: &[f64; 8]) -> CellSurface {
        let Placing { level, epsilon, .. } = self.placing;
        let values = samples.map(|sample| self.sign * (sample - level));
        let t = |edge: usize| {
            let [low, high] = edge_corners(edge);
            crossing(samples[low], samples[high], level, epsilon)
        };
        settle(self.tables, case, &values, t, epsilon)
    }
}
