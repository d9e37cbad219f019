//! The crossings of one family of edges, gathered from words of bits before they are placed.
//!
//! How many bits a word has is not foreseen by any processor; a branch on it costs more than
//! placing a vertex. So bits become a list without such branches, and the list is worked off by
//! loops that are foreseen, whose waiting for samples overlaps.

/// Vertices placed side by side.
pub(super) const LANES: usize = 16;

/// Places that are written at once.
const BLOCK: usize = 8;

/// Crossings gathered before they are placed.
const ROOM: usize = 1024;

/// Crossings: the place in its row, counted as the bits are, and the row.
pub(super) struct Gathered {
    c: [u32; ROOM],
    r: [u32; ROOM],
    n: usize,
}

impl Gathered {
    pub(super) fn new() -> Self {
        Self { c: [0; ROOM], r: [0; ROOM], n: 0 }
    }

    /// Whether the next word may not find room.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.n + 64 > ROOM
    }

    /// Adds the set bits of a word, rising; its first bit stands for `first`. Of a word of zeroes
    /// places are written, but none is counted.
    #[inline(always)]
    pub(super) fn add(&mut self, word: u64, first: u32, r: u32) {
        let mut rest = word;
        let mut at = self.n;
        self.n += word.count_ones() as usize;
        // Eight are written, wanted or not; words with more are rare.
        while let (Some(c), Some(rows)) = (slots(&mut self.c, at), slots(&mut self.r, at)) {
            for slot in c {
                *slot = first + rest.trailing_zeros();
                rest &= rest.wrapping_sub(1);
            }
            *rows = [r; BLOCK];
            if rest == 0 {
                break;
            }
            at += BLOCK;
        }
    }

    /// Adds `n` crossings, 64 at most, of which `block` gives sixteen at a time.
    #[inline(always)]
    pub(super) fn extend(&mut self, n: usize, block: impl Fn(usize) -> ([u32; 16], [u32; 16])) {
        let at = self.n;
        self.n += n;
        for b in 0..n.div_ceil(16).max(1) {
            let from = at + 16 * b;
            let c = self.c.get_mut(from..).and_then(<[u32]>::first_chunk_mut);
            let r = self.r.get_mut(from..).and_then(<[u32]>::first_chunk_mut);
            if let (Some(c), Some(r)) = (c, r) {
                (*c, *r) = block(b);
            }
        }
    }

    /// All of them in order, [`LANES`] at once; the last lanes may hold crossings of old.
    #[inline(always)]
    pub(super) fn batches(&self) -> impl Iterator<Item = (&[u32; LANES], &[u32; LANES])> {
        let batches = self.c.as_chunks().0.iter().zip(self.r.as_chunks().0);
        batches.take(self.n.div_ceil(LANES))
    }

    /// All of them in order.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, u32)> + Clone {
        self.c.iter().copied().zip(self.r.iter().copied()).take(self.n)
    }

    pub(super) fn len(&self) -> usize {
        self.n
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.n = 0;
    }
}

#[inline(always)]
fn slots(list: &mut [u32; ROOM], at: usize) -> Option<&mut [u32; BLOCK]> {
    list.get_mut(at..)?.first_chunk_mut()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_comes_back_once_and_in_order() {
        let words = [1, !0, 1 << 63, 0xFF, 0x1FF, 0x8000_0001_0000_0180];
        let mut gathered = Gathered::new();
        let mut expected = Vec::new();
        for (w, &word) in words.iter().enumerate() {
            gathered.add(word, 64 * w as u32, w as u32);
            let bits = (0..64).filter(|i| word >> i & 1 == 1);
            expected.extend(bits.map(|i| (64 * w as u32 + i, w as u32)));
        }
        assert_eq!(gathered.iter().collect::<Vec<_>>(), expected);
        let batches =
            gathered.batches().flat_map(|(c, r)| c.iter().copied().zip(r.iter().copied()));
        assert_eq!(batches.take(gathered.len()).collect::<Vec<_>>(), expected);
        gathered.clear();
        assert_eq!(gathered.batches().count(), 0);
    }
}
