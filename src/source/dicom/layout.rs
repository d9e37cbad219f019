//! How one image's samples are stored: size, bits, sign, byte order.

use super::error::FileFault;
use super::header::{self, Item, bad};
use super::walk::{PixelElement, Walked};
use super::{syntax, tags};
use crate::geom::Dims;
use crate::volume::StoredType;

/// Room for the headers of one compressed frame, in bytes.
const ENCODED_HEADERS: u64 = 256 << 10;

/// What a stored sample is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum SampleKind {
    /// One bit, eight a byte, low bit first, no padding between rows or frames.
    Bit,
    Unsigned,
    Signed,
    Float,
}

/// The samples of one image or of each frame of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) kind: SampleKind,
    /// Bytes of one sample as stored; 1 for bits.
    pub(super) bytes: usize,
    pub(super) bits_stored: u32,
    pub(super) high_bit: u32,
    pub(super) big: bool,
    /// Bytes written as 16-bit words with the high byte first: neighbours are swapped.
    pub(super) swapped_pairs: bool,
}

impl Layout {
    /// Reads what group 0028 says of the pixels.
    ///
    /// # Errors
    /// An attribute that is absent or cannot be; a plane beyond the limits.
    pub(super) fn read(
        header: &Item,
        walked: &Walked,
        pixels: &PixelElement,
    ) -> Result<Self, FileFault> {
        let needed = |tag, attribute| {
            header::integer(header, tag, attribute)?.ok_or(FileFault::Missing { attribute })
        };
        let rows = needed(tags::ROWS, "Rows")?;
        let cols = needed(tags::COLUMNS, "Columns")?;
        let is_float = pixels.tag != tags::PIXEL_DATA;
        let allocated = if is_float {
            if pixels.tag == tags::FLOAT_PIXEL_DATA { 32 } else { 64 }
        } else {
            needed(tags::BITS_ALLOCATED, "BitsAllocated")?
        };
        let stored = match header::integer(header, tags::BITS_STORED, "BitsStored")? {
            Some(stored) if !is_float => stored,
            _ => allocated,
        };
        let high = match header::integer(header, tags::HIGH_BIT, "HighBit")? {
            Some(high) if !is_float => high,
            _ => stored.saturating_sub(1),
        };
        let sign = header::integer(header, tags::PIXEL_REPRESENTATION, "PixelRepresentation")?;
        let kind = match (is_float, allocated, sign) {
            (true, ..) => SampleKind::Float,
            (false, 1, _) => SampleKind::Bit,
            (false, 8 | 16 | 32, None | Some(0)) => SampleKind::Unsigned,
            (false, 8 | 16 | 32, Some(1)) => SampleKind::Signed,
            (false, 8 | 16 | 32, Some(other)) => {
                return Err(bad("PixelRepresentation", &other.to_string(), "0 or 1"));
            }
            _ => return Err(bad("BitsAllocated", &allocated.to_string(), "1, 8, 16 or 32")),
        };
        if stored < 1 || stored > allocated {
            return Err(bad("BitsStored", &stored.to_string(), "1 to BitsAllocated"));
        }
        if high < stored - 1 || high >= allocated {
            return Err(bad("HighBit", &high.to_string(), "BitsStored - 1 to BitsAllocated - 1"));
        }
        let bytes = (allocated as usize).div_ceil(8);
        let dims = Dims::checked(cols, rows, 1, bytes)?;
        Ok(Self {
            rows: dims.ny(),
            cols: dims.nx(),
            kind,
            bytes,
            bits_stored: stored as u32,
            high_bit: high as u32,
            big: walked.encoding.big || syntax::has_big_pixels(&walked.syntax),
            swapped_pairs: walked.encoding.big && bytes == 1 && pixels.words,
        })
    }

    /// Samples of one frame.
    pub(super) fn n_samples(&self) -> usize {
        self.rows * self.cols
    }

    /// Bytes of one frame, natively stored; bits are counted by [`Self::native_bytes`].
    pub(super) fn frame_bytes(&self) -> usize {
        self.n_samples() * self.bytes
    }

    /// Bytes that `frames` frames need, natively stored.
    pub(super) fn native_bytes(&self, frames: u64) -> Option<u64> {
        let samples = (self.n_samples() as u64).checked_mul(frames)?;
        match self.kind {
            SampleKind::Bit => Some(samples.div_ceil(8)),
            _ => samples.checked_mul(self.bytes as u64),
        }
    }

    /// Bytes beyond which compressed frames are no images of their size: no codec that is read makes
    /// noise more than a little larger, and headers are short.
    pub(super) fn most_encoded(&self, frames: u64) -> u64 {
        let samples = (self.n_samples() * self.bytes) as u64;
        samples.saturating_mul(4).saturating_add(ENCODED_HEADERS).saturating_mul(frames)
    }

    /// The type that planes are handed on in, where neither it nor a slope changes from frame to frame.
    pub(super) fn stored_type(&self) -> StoredType {
        match (self.kind, self.bytes) {
            (SampleKind::Bit, _) | (SampleKind::Unsigned, 1) => StoredType::U8,
            (SampleKind::Unsigned, 2) => StoredType::U16,
            (SampleKind::Unsigned, _) => StoredType::U32,
            (SampleKind::Signed, 1) => StoredType::I8,
            (SampleKind::Signed, 2) => StoredType::I16,
            (SampleKind::Signed, _) => StoredType::I32,
            (SampleKind::Float, 4) => StoredType::F32,
            (SampleKind::Float, _) => StoredType::F64,
        }
    }
}
