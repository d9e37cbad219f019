//! The coded bits between two markers: takes out the zero that is stuffed after FF and reads
//! differences. Knows nothing of samples; never reads past a marker.

use super::huffman::{Huffman, PEEK};

/// Why no more bits could be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// A marker, or the end of the data.
    End,
    /// A code that the table does not have.
    Code,
}

/// Reads bits, the highest of a byte first.
///
/// FF is data only where 0 follows, which is dropped; anything else makes a marker of it (T.81,
/// F.1.2.3).
pub(super) struct Bits<'a> {
    data: &'a [u8],
    /// The next byte that is not in `cache`.
    pos: usize,
    /// Bits not yet taken, from the top; zero below the `held` topmost.
    cache: u64,
    /// At most 63.
    held: u32,
}

const LOW: u64 = 0x0101_0101_0101_0101;
const HIGH: u64 = 0x8080_8080_8080_8080;

impl<'a> Bits<'a> {
    /// Coded data that begin at `pos`.
    pub(super) fn new(data: &'a [u8], pos: usize) -> Self {
        Self { data, pos, cache: 0, held: 0 }
    }

    /// How far the data have been looked at: after [`Fault::End`] or [`Self::finish`], where the
    /// marker stands or the data end.
    pub(super) fn pos(&self) -> usize {
        self.pos
    }

    /// Brings the cache to at least 48 bits, unless a marker or the end comes first.
    #[inline]
    fn refill(&mut self) {
        if let Some(chunk) = self.data.get(self.pos..).and_then(|d| d.first_chunk::<8>()) {
            let word = u64::from_be_bytes(*chunk);
            // The usual test for a zero byte, of the complement.
            if (!word).wrapping_sub(LOW) & word & HIGH == 0 {
                let bytes = (63 - self.held) / 8;
                let held = self.held + 8 * bytes;
                self.cache |= (word >> self.held) & !(u64::MAX >> held);
                self.held = held;
                self.pos += bytes as usize;
                return;
            }
        }
        self.refill_by_bytes();
    }

    #[inline(never)]
    fn refill_by_bytes(&mut self) {
        while self.held <= 55 {
            let Some(&byte) = self.data.get(self.pos) else { return };
            let mut width = 1;
            if byte == 0xFF {
                if self.data.get(self.pos + 1) != Some(&0) {
                    return;
                }
                width = 2;
            }
            self.cache |= u64::from(byte) << (56 - self.held);
            self.held += 8;
            self.pos += width;
        }
    }

    /// Drops `count` bits that are known to be held, at most 63.
    #[inline]
    fn drop_held(&mut self, count: u32) {
        self.cache <<= count;
        self.held -= count;
    }

    /// The next difference (T.81, H.2), -32 767 to 32 768.
    #[inline]
    pub(super) fn difference(&mut self, table: &Huffman) -> Result<i32, Fault> {
        // The longest code and the longest number behind it are 16 bits each.
        if self.held < 32 {
            self.refill();
        }
        let entry = table.entry((self.cache >> (64 - PEEK)) as usize);
        let length = u32::from(entry.length);
        if entry.is_whole && length <= self.held {
            self.drop_held(length);
            return Ok(entry.value);
        }
        self.long_difference(table)
    }

    /// As [`Self::difference`], for what the short table does not hold as a whole.
    #[inline(never)]
    fn long_difference(&mut self, table: &Huffman) -> Result<i32, Fault> {
        let Some((length, category)) = table.code((self.cache >> 48) as u16) else {
            // Zeros stand where bits are missing.
            return Err(if self.held < 16 { Fault::End } else { Fault::Code });
        };
        // The one difference of category 16 has no bits of its own (T.81, H.1.2.2).
        let bits = if category == 16 { 0 } else { category };
        if length + bits > self.held {
            return Err(Fault::End);
        }
        self.drop_held(length);
        let number = (self.cache >> 1 >> (63 - bits)) as u32;
        self.drop_held(bits);
        Ok(extend(number, category))
    }

    /// Goes on to the marker that ends the data, over what an encoder adds to fill its last byte:
    /// less than two bytes of anything, then zeros.
    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.refill_by_bytes();
        self.drop_held(self.held.min(15));
        loop {
            if self.cache != 0 {
                return Err(Fault::Code);
            }
            self.held = 0;
            self.refill_by_bytes();
            if self.held == 0 {
                return Ok(());
            }
        }
    }
}

/// The difference of a category (0 to 16) that `number` numbers (T.81, F.2.2.1 and H.1.2.2).
pub(super) fn extend(number: u32, category: u32) -> i32 {
    match category {
        0 => 0,
        16 => 1 << 15,
        _ if number >> (category - 1) != 0 => number as i32,
        _ => number as i32 - (1 << category) + 1,
    }
}
