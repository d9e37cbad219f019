//! Where the surface may be: in all cells, those of the border included, or between samples alone.

use std::ops::Range;

/// The edges and cells that count.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Samples a row, and rows.
    pub(super) dims: (usize, usize),
    /// Only what lies between samples counts, so there is no cap.
    pub(super) open: bool,
}

impl Region {
    /// What counts of all that stands at the bits of word `w` and reaches back to the bit before:
    /// X edges, cells, diagonals along x.
    #[inline(always)]
    pub(super) fn columns(self, w: usize) -> u64 {
        if !self.open {
            return !0;
        }
        let nx = self.dims.0;
        let first = if w == 0 { !1 } else { !0 };
        let last = if w == nx / 64 { (1 << (nx % 64)) - 1 } else { !0 };
        first & last
    }

    /// The rows that count of all that reaches back to the row before: Y edges, cells, diagonals
    /// along y. Rows as those of bit planes are counted.
    #[inline(always)]
    pub(super) fn rows(self) -> Range<usize> {
        let ny = self.dims.1;
        if self.open { 2..ny + 1 } else { 1..ny + 2 }
    }

    /// Whether what lies between two planes counts, of which one may be the border.
    #[inline(always)]
    pub(super) fn has_layer(self, in_border: bool) -> bool {
        !(self.open && in_border)
    }
}
