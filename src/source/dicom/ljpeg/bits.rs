//! Differences from coded bits: a Huffman code, and the number behind it.

use super::huffman::{Huffman, PEEK, extend};
use crate::source::dicom::bits::{self, Fault, Stuffing};

pub(super) type Bits<'a> = bits::Bits<'a, Zeros>;

/// FF is data only where 0 follows, which is dropped; anything else makes a marker of it (T.81,
/// F.1.2.3).
#[derive(Default)]
pub(super) struct Zeros;

impl Stuffing for Zeros {
    /// Less than two bytes.
    const FILL: u32 = 15;

    #[inline]
    fn is_plain(&self) -> bool {
        true
    }

    #[inline]
    fn next(&mut self, bytes: &[u8]) -> Option<(u8, u32, usize)> {
        match *bytes {
            [0xFF, 0, ..] => Some((0xFF, 8, 2)),
            [0xFF, ..] | [] => None,
            [byte, ..] => Some((byte, 8, 1)),
        }
    }
}

impl Bits<'_> {
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
        let number = self.take_held(bits);
        Ok(extend(number, category))
    }
}
