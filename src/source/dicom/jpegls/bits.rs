//! The coded bits between two markers: takes out the bits that are stuffed after FF and reads
//! Golomb codes. Knows nothing of samples; never reads past a marker.

/// Why no more bits could be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// A marker, or the end of the data.
    End,
    /// A code that the standard does not have.
    Code,
}

/// Reads bits, the highest of a byte first.
///
/// A byte after FF carries seven bits, its highest being 0; where it is 1, FF begins a marker
/// (T.87, A.1 and C.1).
pub(super) struct Bits<'a> {
    data: &'a [u8],
    /// The next byte that is not in `cache`.
    pos: usize,
    /// Bits not yet taken, from the top; zero below the `held` topmost.
    cache: u64,
    /// At most 63.
    held: u32,
    /// The byte before `pos` was FF.
    after_ff: bool,
}

const LOW: u64 = 0x0101_0101_0101_0101;
const HIGH: u64 = 0x8080_8080_8080_8080;

impl<'a> Bits<'a> {
    /// Coded data that begin at `pos`.
    pub(super) fn new(data: &'a [u8], pos: usize) -> Self {
        Self { data, pos, cache: 0, held: 0, after_ff: false }
    }

    /// How far the data have been looked at: after [`Fault::End`] or [`Self::finish`], where the
    /// marker stands or the data end.
    pub(super) fn pos(&self) -> usize {
        self.pos
    }

    /// Brings the cache to at least 48 bits, unless a marker or the end comes first.
    #[inline]
    fn refill(&mut self) {
        if !self.after_ff
            && let Some(chunk) = self.data.get(self.pos..).and_then(|d| d.first_chunk::<8>())
        {
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
            let width = if self.after_ff {
                7
            } else {
                // FF is data only where a byte with a stuffed 0 follows.
                if byte == 0xFF && self.data.get(self.pos + 1).is_none_or(|&b| b >= 0x80) {
                    return;
                }
                8
            };
            // A byte after FF is below 80, so its seven bits need no mask.
            self.cache |= u64::from(byte) << (64 - width - self.held);
            self.held += width;
            self.after_ff = byte == 0xFF;
            self.pos += 1;
        }
    }

    /// Drops `count` bits that are known to be held, at most 63.
    #[inline]
    fn drop_held(&mut self, count: u32) {
        self.cache <<= count;
        self.held -= count;
    }

    /// One bit.
    #[inline]
    pub(super) fn bit(&mut self) -> Result<bool, Fault> {
        if self.held == 0 {
            self.refill();
            if self.held == 0 {
                return Err(Fault::End);
            }
        }
        let bit = self.cache >> 63 != 0;
        self.drop_held(1);
        Ok(bit)
    }

    /// `count` bits as a number, at most 31.
    #[inline]
    pub(super) fn number(&mut self, count: u32) -> Result<u32, Fault> {
        if self.held < count {
            self.refill();
            if self.held < count {
                return Err(Fault::End);
            }
        }
        let number = (self.cache >> 1 >> (63 - count)) as u32;
        self.drop_held(count);
        Ok(number)
    }

    /// A Golomb code with parameter `k`, limited in length (T.87, A.5.3): `escape` zeros say that
    /// `qbpp` plain bits follow.
    #[inline]
    pub(super) fn golomb(&mut self, k: u32, escape: u32, qbpp: u32) -> Result<u32, Fault> {
        if self.held < 32 {
            self.refill();
        }
        let zeros = self.cache.leading_zeros();
        let length = zeros + 1 + k;
        if length > self.held || zeros >= escape {
            return self.long_golomb(k, escape, qbpp);
        }
        let rest = self.cache << zeros << 1;
        self.cache = rest << k;
        self.held -= length;
        Ok((zeros << k) | (rest >> 1 >> (63 - k)) as u32)
    }

    #[cold]
    #[inline(never)]
    fn long_golomb(&mut self, k: u32, escape: u32, qbpp: u32) -> Result<u32, Fault> {
        let mut zeros = 0;
        loop {
            self.refill();
            if self.held == 0 {
                return Err(Fault::End);
            }
            let here = self.cache.leading_zeros().min(self.held);
            zeros += here;
            if zeros > escape {
                return Err(Fault::Code);
            }
            let found = here < self.held;
            self.drop_held(here);
            if found {
                break;
            }
        }
        self.drop_held(1);
        if zeros < escape { Ok((zeros << k) | self.number(k)?) } else { Ok(self.number(qbpp)? + 1) }
    }

    /// Goes on to the marker that ends the data, over what an encoder adds to fill its last byte:
    /// less than two bytes of anything (a last byte FF asks for one more), then zeros.
    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.refill_by_bytes();
        self.drop_held(self.held.min(14));
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
