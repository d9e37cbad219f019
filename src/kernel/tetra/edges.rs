//! The diagonals of the split that the surface crosses, counted row by row from words of bits.
//!
//! A diagonal belongs to the row of its upper end. In a row it stands at the bit of that end, so the
//! lower end's word is shifted by one where the diagonal goes along x.

use std::ops::Range;

use super::super::bits::BitPlane;
use super::super::region::Region;

/// Diagonals of one kind: where the upper end lies from the lower one, seen along z.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Kind {
    /// 0 or 1 sample along x.
    pub(super) dx: usize,
    /// 0 or 1 row along y.
    pub(super) dy: usize,
}

impl Kind {
    /// Those in a plane, and the main diagonals of cells.
    pub(super) const XY: Self = Self { dx: 1, dy: 1 };
    /// Those between two planes along a row.
    pub(super) const XZ: Self = Self { dx: 1, dy: 0 };
    /// Those between two planes along a column.
    pub(super) const YZ: Self = Self { dx: 0, dy: 1 };

    /// The rows of upper ends, counted as those of bit planes are.
    pub(super) fn rows(self, region: Region) -> Range<usize> {
        if self.dy == 0 { 1..region.dims.1 + 1 } else { region.rows() }
    }

    /// The crossed diagonals whose upper ends stand at word `w` of row `q`.
    #[inline(always)]
    pub(super) fn crossed(self, region: Region, low: &[u64], high: &[u64], w: usize) -> u64 {
        if self.dx == 0 {
            return low[w + 1] ^ high[w + 1];
        }
        ((low[w + 1] << 1 | low[w] >> 63) ^ high[w + 1]) & region.columns(w)
    }
}

/// How many diagonals of a kind are crossed, with what numbers them row by row.
#[derive(Debug, Default)]
pub(in super::super) struct Crossings {
    before: Vec<u32>,
}

impl Crossings {
    /// Crossings before those of row `q`.
    #[inline(always)]
    pub(super) fn before(&self, q: usize) -> u32 {
        self.before[q]
    }

    /// All of them.
    pub(in super::super) fn total(&self) -> u32 {
        self.before.last().copied().unwrap_or(0)
    }

    /// Makes these the same as others.
    pub(in super::super) fn copy_from(&mut self, other: &Self) {
        self.before.clone_from(&other.before);
    }

    /// There are none.
    pub(super) fn clear(&mut self, ny: usize) {
        self.before.clear();
        self.before.resize(ny + 3, 0);
    }

    /// Counts the diagonals of a kind from one plane to another, or within one plane.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(in super::super) fn fill_with(
        &mut self,
        region: Region,
        kind: Kind,
        low: &BitPlane,
        high: &BitPlane,
    ) {
        let ny = region.dims.1;
        let words = high.row_words();
        let rows = kind.rows(region);
        self.before.resize(ny + 3, 0);
        let mut n = 0;
        for q in 1..=ny + 1 {
            self.before[q] = n;
            if !rows.contains(&q) || !(low.any(q - kind.dy) || high.any(q)) {
                continue;
            }
            let (low, high) = (&low.row(q - kind.dy)[..=words], &high.row(q)[..=words]);
            for w in 0..words {
                n += kind.crossed(region, low, high, w).count_ones();
            }
        }
        self.before[ny + 2] = n;
    }
}

/// The crossed diagonals between two planes.
#[derive(Debug, Default)]
pub(in super::super) struct Diagonals {
    pub(super) xz: Crossings,
    pub(super) yz: Crossings,
    /// Main diagonals of cells.
    pub(super) body: Crossings,
}

impl Diagonals {
    /// All of them.
    pub(in super::super) fn total(&self) -> u64 {
        [&self.xz, &self.yz, &self.body].into_iter().map(|c| u64::from(c.total())).sum()
    }
}
