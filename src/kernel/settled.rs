//! Cells whose case alone does not say what their surface is.

use super::emit::SettledCell;
use super::slab::LayerScratch;
use super::{Classify, Kernel};
use crate::mesh::Position;

/// What became of a layer's slow cells.
#[derive(Debug, Default)]
pub(super) struct Settled {
    /// One for each slow cell.
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
    /// Settles the slow cells of layer `s`, between two planes of samples.
    pub(super) fn settle(&self, s: usize, samples: [Option<&[T]>; 2], layer: &mut LayerScratch) {
        let _ = (s, samples, self.sign);
        let LayerScratch { cells, settled, .. } = layer;
        for slow in &cells.slow {
            let row = self.tables.first_row[usize::from(slow.case)];
            let _ = slow.c;
            let triangles = self.tables.rows[usize::from(row)].n_triangles;
            settled.cells.push(SettledCell { row, n_extra: 0 });
            settled.n_triangles += u64::from(triangles);
        }
    }
}
