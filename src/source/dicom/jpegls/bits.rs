//! Golomb codes and plain numbers from coded bits.

use crate::source::dicom::bits::{self, Fault, Stuffing};

pub(super) type Bits<'a> = bits::Bits<'a, SevenBits>;

/// A byte after FF carries seven bits, its highest being 0; where it is 1, FF begins a marker
/// (T.87, A.1 and C.1).
#[derive(Default)]
pub(super) struct SevenBits {
    /// The byte before was FF.
    after_ff: bool,
}

impl Stuffing for SevenBits {
    /// Less than two bytes; a last byte FF asks for one more.
    const FILL: u32 = 14;

    #[inline]
    fn is_plain(&self) -> bool {
        !self.after_ff
    }

    #[inline]
    fn next(&mut self, bytes: &[u8]) -> Option<(u8, u32, usize)> {
        let (&byte, rest) = bytes.split_first()?;
        // FF is data only where a byte with a stuffed 0 follows.
        if !self.after_ff && byte == 0xFF && rest.first().is_none_or(|&b| b >= 0x80) {
            return None;
        }
        // A byte after FF is below 80, so its seven bits need no mask.
        let width = if self.after_ff { 7 } else { 8 };
        self.after_ff = byte == 0xFF;
        Some((byte, width, 1))
    }
}

impl Bits<'_> {
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
        Ok(self.take_held(count))
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
}
