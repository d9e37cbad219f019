//! Bit planes: whether each sample of one plane is inside, one bit a sample.

use std::ops::Range;

use super::region::Region;

/// No rows, so that a union with it changes nothing.
const NO_ROWS: Range<usize> = Range { start: usize::MAX, end: 0 };

/// The inside bits of one plane, 64 a word, i in rising bit order, with what numbers the crossings
/// in the plane.
///
/// Rows are counted from the border, whose rows are always zero; rows of cells lie between them:
///
/// ```text
/// row j of samples       -1    0    1  ..  ny-1   ny
/// row q of a bit plane    0    1    2  ..   ny   ny+1
/// row r of cells             0    1    ..      ny        r between the rows q = r and q = r + 1
/// ```
///
/// A row has `ceil((nx + 1) / 64)` words, rounded up to a multiple of eight; bits from
/// `nx` on are zero, so the topmost bit of each row is zero and the word before a row is a valid
/// carry into it. One word stands in front of the first row for that.
#[derive(Debug)]
pub(super) struct BitPlane {
    nx: usize,
    ny: usize,
    stride: usize,
    words: Vec<u64>,
    /// Whether a row has a bit.
    any: Vec<bool>,
    /// From the first row with a bit to behind the last.
    some: Range<usize>,
    /// X crossings in the rows before each row.
    x_before: Vec<u32>,
    /// Y crossings before each row; those of row q lie between rows q - 1 and q.
    y_before: Vec<u32>,
}

/// Words of a row.
fn stride(nx: usize) -> usize {
    (nx / 64 + 1).next_multiple_of(8)
}

impl BitPlane {
    /// All outside.
    pub(super) fn new(nx: usize, ny: usize) -> Self {
        let stride = stride(nx);
        Self {
            nx,
            ny,
            stride,
            words: vec![0; 1 + stride * (ny + 2)],
            any: vec![false; ny + 2],
            some: NO_ROWS,
            x_before: vec![0; ny + 3],
            y_before: vec![0; ny + 3],
        }
    }

    /// Bytes that a plane takes.
    pub(super) fn bytes(nx: usize, ny: usize) -> u64 {
        let a_row = 8 * stride(nx) + size_of::<bool>() + 2 * size_of::<u32>();
        (ny as u64 + 3).saturating_mul(a_row as u64)
    }

    /// Makes this plane the same as another.
    pub(super) fn copy_from(&mut self, other: &Self) {
        (self.nx, self.ny, self.stride) = (other.nx, other.ny, other.stride);
        self.words.clone_from(&other.words);
        self.any.clone_from(&other.any);
        self.some.clone_from(&other.some);
        self.x_before.clone_from(&other.x_before);
        self.y_before.clone_from(&other.y_before);
    }

    /// Words of a row that can hold a bit, the border's to the right of the last sample included.
    pub(super) fn row_words(&self) -> usize {
        self.nx / 64 + 1
    }

    /// Row `q` with the word before it in front: `1 + row_words` words at least.
    #[inline(always)]
    pub(super) fn row(&self, q: usize) -> &[u64] {
        &self.words[q * self.stride..][..=self.stride]
    }

    /// Word `w` of row `q`.
    #[inline(always)]
    pub(super) fn word(&self, q: usize, w: usize) -> u64 {
        self.words[1 + q * self.stride + w]
    }

    /// The crossed X edges of word `w` of row `q`, each at the bit of its right-hand end.
    #[inline(always)]
    pub(super) fn x_crossings(&self, region: Region, q: usize, w: usize) -> u64 {
        along_x(region, self.row(q), w)
    }

    /// The crossed Y edges between the rows `q - 1` and `q`, at word `w`.
    #[inline(always)]
    pub(super) fn y_crossings(&self, region: Region, q: usize, w: usize) -> u64 {
        if region.rows().contains(&q) { self.word(q - 1, w) ^ self.word(q, w) } else { 0 }
    }

    /// Whether row `q` has a bit.
    #[inline(always)]
    pub(super) fn any(&self, q: usize) -> bool {
        self.any[q]
    }

    /// The rows from the first with a bit to behind the last; a range that ends before it starts
    /// where there is none.
    #[inline(always)]
    pub(super) fn some_rows(&self) -> Range<usize> {
        self.some.clone()
    }

    /// X crossings in the rows before row `q`.
    #[inline(always)]
    pub(super) fn x_before(&self, q: usize) -> u32 {
        self.x_before[q]
    }

    /// Y crossings before those between rows `q - 1` and `q`.
    #[inline(always)]
    pub(super) fn y_before(&self, q: usize) -> u32 {
        self.y_before[q]
    }

    /// All X crossings of the plane.
    pub(super) fn n_x(&self) -> u32 {
        self.x_before[self.ny + 2]
    }

    /// All Y crossings of the plane.
    pub(super) fn n_y(&self) -> u32 {
        self.y_before[self.ny + 2]
    }

    /// Makes every sample outside.
    pub(super) fn clear(&mut self) {
        self.words.fill(0);
        self.any.fill(false);
        self.some = NO_ROWS;
        self.x_before.fill(0);
        self.y_before.fill(0);
    }

    /// Takes a plane of samples; `classify` turns 64 of them into a word.
    ///
    /// Inlined into one function an instruction set, so that all of it is compiled for that set.
    #[inline(always)]
    pub(super) fn fill_with<K: Copy + Default>(
        &mut self,
        samples: &[K],
        region: Region,
        classify: impl Fn(&[K; 64]) -> u64,
    ) {
        // Two streams, the upper half of the plane and the lower, keep more of the memory's
        // channels busy than one.
        let half = self.ny / 2;
        let rows = &mut self.words[1 + self.stride..][..self.ny * self.stride];
        let (upper, lower) = rows.split_at_mut(half * self.stride);
        let (upper_any, lower_any) = self.any[1..=self.ny].split_at_mut(half);
        let (upper_samples, lower_samples) = samples.split_at(half * self.nx);
        let mut upper = upper
            .chunks_exact_mut(self.stride)
            .zip(upper_any)
            .zip(upper_samples.chunks_exact(self.nx));
        let lower = lower
            .chunks_exact_mut(self.stride)
            .zip(lower_any)
            .zip(lower_samples.chunks_exact(self.nx));
        for ((row, any), samples) in lower {
            *any = fill_row(row, samples, &classify) != 0;
            if let Some(((row, any), samples)) = upper.next() {
                *any = fill_row(row, samples, &classify) != 0;
            }
        }
        self.some = match self.any.iter().position(|&any| any) {
            Some(first) => first..self.any.iter().rposition(|&any| any).map_or(0, |q| q + 1),
            None => NO_ROWS,
        };
        self.count_crossings(region);
    }

    /// Numbers the crossings in the plane, row by row: a pass of its own, so that the comparison
    /// runs at the speed of memory.
    #[inline(always)]
    fn count_crossings(&mut self, region: Region) {
        let words = self.row_words();
        let (mut n_x, mut n_y) = (0, 0);
        self.x_before.fill(0);
        self.y_before.fill(0);
        if self.some.is_empty() {
            return;
        }
        for q in self.some.start..=self.some.end {
            self.x_before[q] = n_x;
            self.y_before[q] = n_y;
            if !self.any[q] && !self.any[q - 1] {
                continue;
            }
            let (above, row) = (&self.row(q - 1)[..=words], &self.row(q)[..=words]);
            n_x += (0..words).map(|w| along_x(region, row, w).count_ones()).sum::<u32>();
            if region.rows().contains(&q) {
                n_y +=
                    above.iter().zip(row).skip(1).map(|(a, b)| (a ^ b).count_ones()).sum::<u32>();
            }
        }
        self.x_before[self.some.end + 1..].fill(n_x);
        self.y_before[self.some.end + 1..].fill(n_y);
    }
}

/// Turns a row of samples into words; gives back their union.
#[inline(always)]
fn fill_row<K: Copy + Default>(
    row: &mut [u64],
    samples: &[K],
    classify: &impl Fn(&[K; 64]) -> u64,
) -> u64 {
    let (whole, rest) = samples.as_chunks::<64>();
    let mut any = 0;
    for (word, chunk) in row.iter_mut().zip(whole) {
        *word = classify(chunk);
        any |= *word;
    }
    if !rest.is_empty() {
        let mut chunk = [K::default(); 64];
        chunk[..rest.len()].copy_from_slice(rest);
        let word = classify(&chunk) & ((1 << rest.len()) - 1);
        row[whole.len()] = word;
        any |= word;
    }
    any
}

/// The crossed X edges of word `w` of a row, which comes with the word before it.
#[inline(always)]
fn along_x(region: Region, row: &[u64], w: usize) -> u64 {
    (row[w + 1] ^ (row[w + 1] << 1 | row[w] >> 63)) & region.columns(w)
}
