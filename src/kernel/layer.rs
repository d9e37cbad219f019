//! The cells between two planes: which are active, and their cases, from words of inside bits.

use super::bits::BitPlane;
use super::region::Region;

/// A row of cells in which at least one is active.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowRun {
    /// Cell rows count from 0, between the border and the first row of samples, to `ny`.
    pub(super) row: u32,
    /// Active cells.
    pub(super) n_cells: u32,
    /// Those among them that are unsettled.
    pub(super) n_unsettled: u32,
}

/// An active cell whose case alone does not say what its surface is.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnsettledCell {
    /// Its place in the row, 0 to `nx`; between the samples c - 1 and c.
    pub(super) c: u32,
    /// How many active cells of the row come before it.
    pub(super) nth: u32,
    /// Its inside bits.
    pub(super) case: u8,
}

/// A word of a row of bits in which some cell has corners of both kinds: all crossings of the row
/// of cells are in such words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ActiveWord {
    /// As rows of bit planes are counted.
    pub(super) q: u32,
    pub(super) w: u32,
}

/// Triangles of each case, and, as the topmost bit, whether the case leaves the cell unsettled (its
/// triangles are not counted here then).
pub(super) type Counts = [u8; 256];

/// Set in [`Counts`] where a case leaves the cell unsettled.
pub(super) const UNSETTLED: u8 = 0x80;

/// One layer of cells. Its vectors only grow, so that a worker's next layer allocates nothing.
#[derive(Debug, Default)]
pub(super) struct Layer {
    /// The cases of the active cells, in order; garbage after the first `n_cases`.
    cases: Vec<u8>,
    n_cases: usize,
    /// The rows that have active cells, in order.
    pub(super) rows: Vec<RowRun>,
    /// The unsettled cells, in order.
    pub(super) unsettled: Vec<UnsettledCell>,
    /// Where crossings are, by (y, x): those of the layer's Z edges and of the X and Y edges of the
    /// plane after it.
    pub(super) words: Vec<ActiveWord>,
    /// Z crossings in the rows of samples before each row, counted as the rows of bit planes are.
    z_before: Vec<u32>,
    /// Triangles of the other cells.
    pub(super) n_plain_triangles: u64,
}

/// Where a row of cells puts what it finds.
pub(super) struct RowOut<'a> {
    /// The row, as those of bit planes are counted.
    pub(super) q: u32,
    pub(super) cases: &'a mut [u8],
    pub(super) unsettled: &'a mut Vec<UnsettledCell>,
    pub(super) words: &'a mut Vec<ActiveWord>,
}

/// What is found in one row of cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RowCells {
    pub(super) n_cells: usize,
    pub(super) n_triangles: u32,
}

/// Four rows of bits around a row of cells, each with the word before it: A and B from the plane
/// before (row r - 1, row r), C and D from the plane after.
pub(super) type FourRows<'a> = [&'a [u64]; 4];

/// Bytes that a row function may write past the cases that it counts.
pub(super) const CASE_SLACK: usize = 64;

impl Layer {
    /// The cases of all active cells, in order.
    pub(super) fn cases(&self) -> &[u8] {
        &self.cases[..self.n_cases]
    }

    /// Z crossings in the rows before row `q`.
    #[inline(always)]
    pub(super) fn z_before(&self, q: usize) -> u32 {
        self.z_before[q]
    }

    /// All Z crossings of the layer.
    pub(super) fn n_z(&self) -> u32 {
        self.z_before.last().copied().unwrap_or(0)
    }

    /// Finds crossings and cases between two planes. `row_cells` finds the cells of one row;
    /// `cells` bounds the cells that may be active.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(super) fn fill_with(
        &mut self,
        planes: [&BitPlane; 2],
        (nx, ny): (usize, usize),
        cells: Cells,
        row_cells: impl Fn(FourRows<'_>, RowMask, RowOut<'_>) -> RowCells,
    ) {
        let [prev, cur] = planes;
        let words = prev.row_words();
        self.n_cases = 0;
        self.rows.clear();
        self.unsettled.clear();
        self.words.clear();
        self.n_plain_triangles = 0;
        self.z_before.clear();
        self.z_before.resize(ny + 3, 0);
        let some = prev.some_rows().start.min(cur.some_rows().start)
            ..prev.some_rows().end.max(cur.some_rows().end);
        if some.is_empty() {
            return;
        }
        let mut n_z = 0;
        for q in some.start..=some.end {
            self.z_before[q] = n_z;
            if !(prev.any(q - 1) || prev.any(q) || cur.any(q - 1) || cur.any(q)) {
                continue;
            }
            let rows = [prev.row(q - 1), prev.row(q), cur.row(q - 1), cur.row(q)];
            if cells.region.has_layer(cells.in_border) {
                let (b, d) = (&rows[1][1..=words], &rows[3][1..=words]);
                n_z += b.iter().zip(d).map(|(b, d)| (b ^ d).count_ones()).sum::<u32>();
            }
            let room = self.n_cases + nx + 1 + CASE_SLACK;
            if self.cases.len() < room {
                self.cases.resize(room.next_power_of_two(), 0);
            }
            let unsettled_before = self.unsettled.len();
            let out = RowOut {
                q: q as u32,
                cases: &mut self.cases[self.n_cases..],
                unsettled: &mut self.unsettled,
                words: &mut self.words,
            };
            let found = row_cells(rows, cells.row(q), out);
            if found.n_cells > 0 {
                self.n_cases += found.n_cells;
                self.n_plain_triangles += u64::from(found.n_triangles);
                self.rows.push(RowRun {
                    row: q as u32 - 1,
                    n_cells: found.n_cells as u32,
                    n_unsettled: (self.unsettled.len() - unsettled_before) as u32,
                });
            }
        }
        self.z_before[some.end + 1..].fill(n_z);
    }
}

/// Which cells of a layer may be active.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    pub(super) region: Region,
    /// The layer lies between the border and the first or the last plane.
    pub(super) in_border: bool,
}

impl Cells {
    /// Those of row `q`.
    #[inline(always)]
    fn row(self, q: usize) -> RowMask {
        let Self { region, in_border } = self;
        RowMask { region, is_none: !region.has_layer(in_border) || !region.rows().contains(&q) }
    }
}

/// Which cells of a row may be active.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowMask {
    region: Region,
    is_none: bool,
}

impl RowMask {
    /// The bits of word `w` that may be active.
    #[inline(always)]
    pub(super) fn word(self, w: usize) -> u64 {
        if self.is_none { 0 } else { self.region.columns(w) }
    }
}

/// The words of a row of cells at word `w`: A, B, C, D shifted to the cell's left corner, and as
/// they are, for its right corner.
#[inline(always)]
pub(super) fn corner_words(rows: FourRows<'_>, w: usize) -> ([u64; 4], [u64; 4]) {
    let right = rows.map(|row| row[w + 1]);
    let left = rows.map(|row| row[w + 1] << 1 | row[w] >> 63);
    (left, right)
}

/// The cells of word `w` that have corners of both kinds.
#[inline(always)]
pub(super) fn active((left, right): ([u64; 4], [u64; 4])) -> u64 {
    let [a, b, c, d] = left;
    let [e, f, g, h] = right;
    (a | b | c | d | e | f | g | h) & !(a & b & c & d & e & f & g & h)
}

/// The definition of a row's cells: one active bit after the other, in windows of two bits.
#[inline(always)]
pub(super) fn row_cells(
    counts: &Counts,
    rows: FourRows<'_>,
    words: usize,
    mask: RowMask,
    out: RowOut<'_>,
) -> RowCells {
    let mut found = RowCells::default();
    let mut slots = out.cases.iter_mut();
    let rows = rows.map(|row| &row[..=words]);
    for w in 0..words {
        let corners = corner_words(rows, w);
        let active = active(corners);
        if active == 0 {
            continue;
        }
        out.words.push(ActiveWord { q: out.q, w: w as u32 });
        let mut bits = active & mask.word(w);
        let (left, right) = corners;
        while bits != 0 {
            let t = bits.trailing_zeros();
            bits &= bits - 1;
            let case = if t == 0 {
                let pair = |i: usize| (left[i] & 1 | (right[i] & 1) << 1) as u8;
                pair(0) | pair(1) << 2 | pair(2) << 4 | pair(3) << 6
            } else {
                let pair = |i: usize| (right[i] >> (t - 1)) as u8 & 3;
                pair(0) | pair(1) << 2 | pair(2) << 4 | pair(3) << 6
            };
            if let Some(slot) = slots.next() {
                *slot = case;
            }
            let count = counts[case as usize];
            if count & UNSETTLED == 0 {
                found.n_triangles += u32::from(count);
            } else {
                out.unsettled.push(UnsettledCell {
                    c: w as u32 * 64 + t,
                    nth: found.n_cells as u32,
                    case,
                });
            }
            found.n_cells += 1;
        }
    }
    found
}
