//! The fields of NIfTI-1 and NIfTI-2 headers, by offset and byte order, as they stand in the file.
//!
//! Judges nothing but size, byte order and magic. Offsets: nifti1.h and nifti2.h of the NIfTI-1.1
//! and NIfTI-2 standards.

use super::NiftiError;
use crate::source::SourceError;

/// Bytes of a NIfTI-1 header.
pub(super) const SIZE_1: usize = 348;

/// Bytes of a NIfTI-2 header.
pub(super) const SIZE_2: usize = 540;

/// A header's fields in this machine's numbers.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::source) struct Fields {
    /// 1 or 2.
    pub(in crate::source) version: u8,
    pub(in crate::source) big_endian: bool,
    /// Whether the samples stand in the same file (`n+1`), not in a `.img` (`ni1`).
    pub(in crate::source) single: bool,
    pub(in crate::source) dim: [i64; 8],
    pub(in crate::source) datatype: i16,
    pub(in crate::source) bitpix: i16,
    pub(in crate::source) pixdim: [f64; 8],
    pub(in crate::source) vox_offset: VoxOffset,
    pub(in crate::source) scl_slope: f64,
    pub(in crate::source) scl_inter: f64,
    pub(in crate::source) xyzt_units: i32,
    pub(in crate::source) qform_code: i32,
    pub(in crate::source) sform_code: i32,
    /// b, c, d.
    pub(in crate::source) quatern: [f64; 3],
    pub(in crate::source) qoffset: [f64; 3],
    pub(in crate::source) srow: [[f64; 4]; 3],
}

/// The field as the two versions store it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::source) enum VoxOffset {
    Float(f32),
    Integer(i64),
}

/// Version and byte order that `sizeof_hdr` tells.
pub(super) fn version_of(head: &[u8]) -> Option<(u8, bool)> {
    let size = Reader { bytes: head, big: false }.i32(0);
    match (size, size.swap_bytes()) {
        (348, _) => Some((1, false)),
        (540, _) => Some((2, false)),
        (_, 348) => Some((1, true)),
        (_, 540) => Some((2, true)),
        _ => None,
    }
}

/// Whether a file's first bytes are those of a NIfTI header, a damaged one included.
pub(in crate::source) fn recognise(head: &[u8]) -> bool {
    version_of(head).is_some()
        || magic_at(head, 344, b'1').is_some()
        || magic_at(head, 4, b'2').is_some()
}

/// Whether a file's first bytes are those of a header whose samples stand in another file.
pub(in crate::source) fn is_of_pair(head: &[u8]) -> bool {
    match version_of(head) {
        Some((1, _)) => magic_at(head, 344, b'1') == Some(false),
        Some(_) => magic_at(head, 4, b'2') == Some(false),
        None => false,
    }
}

/// Whether the samples stand in the same file, by the magic at `at`; nothing where there is none.
fn magic_at(head: &[u8], at: usize, version: u8) -> Option<bool> {
    match *head.get(at..at + 4)? {
        [b'n', b'+', v, 0] if v == version => Some(true),
        [b'n', b'i', v, 0] if v == version => Some(false),
        _ => None,
    }
}

impl Fields {
    /// Takes a header apart. `head` holds the first bytes of the file, as many as there are up to
    /// the size of the longer header.
    pub(super) fn parse(head: &[u8]) -> Result<Self, SourceError> {
        let short = |of| NiftiError::ShortHeader { found: head.len(), of };
        let Some((version, big)) = version_of(head) else {
            if head.len() < SIZE_1 {
                return Err(short(SIZE_1).into());
            }
            return Err(if recognise(head) {
                NiftiError::HeaderSize(Reader { bytes: head, big: false }.i32(0)).into()
            } else {
                SourceError::UnknownFormat(None)
            });
        };
        let size = if version == 1 { SIZE_1 } else { SIZE_2 };
        let Some(bytes) = head.get(..size) else { return Err(short(size).into()) };
        let read = Reader { bytes, big };
        Ok(if version == 1 { Self::parse_1(&read)? } else { Self::parse_2(&read)? })
    }

    fn parse_1(read: &Reader<'_>) -> Result<Self, NiftiError> {
        let magic = read.array::<4>(344);
        let Some(single) = magic_at(read.bytes, 344, b'1') else {
            return Err(if magic == [0; 4] {
                NiftiError::Analyze
            } else {
                NiftiError::magic(&magic, 1)
            });
        };
        Ok(Self {
            version: 1,
            big_endian: read.big,
            single,
            dim: std::array::from_fn(|d| i64::from(read.i16(40 + 2 * d))),
            datatype: read.i16(70),
            bitpix: read.i16(72),
            pixdim: std::array::from_fn(|d| f64::from(read.f32(76 + 4 * d))),
            vox_offset: VoxOffset::Float(read.f32(108)),
            scl_slope: f64::from(read.f32(112)),
            scl_inter: f64::from(read.f32(116)),
            xyzt_units: i32::from(read.array::<1>(123)[0]),
            qform_code: i32::from(read.i16(252)),
            sform_code: i32::from(read.i16(254)),
            quatern: std::array::from_fn(|d| f64::from(read.f32(256 + 4 * d))),
            qoffset: std::array::from_fn(|d| f64::from(read.f32(268 + 4 * d))),
            srow: std::array::from_fn(|r| {
                std::array::from_fn(|c| f64::from(read.f32(280 + 16 * r + 4 * c)))
            }),
        })
    }

    fn parse_2(read: &Reader<'_>) -> Result<Self, NiftiError> {
        let magic = read.array::<8>(4);
        let Some(single) = magic_at(read.bytes, 4, b'2') else {
            return Err(NiftiError::magic(&magic, 2));
        };
        // The tail tells a transfer that changed line ends; some writers leave it zero.
        if !matches!(magic[4..], [b'\r', b'\n', 0x1a, b'\n'] | [0, 0, 0, 0]) {
            return Err(NiftiError::TextMode);
        }
        Ok(Self {
            version: 2,
            big_endian: read.big,
            single,
            dim: std::array::from_fn(|d| read.i64(16 + 8 * d)),
            datatype: read.i16(12),
            bitpix: read.i16(14),
            pixdim: std::array::from_fn(|d| read.f64(104 + 8 * d)),
            vox_offset: VoxOffset::Integer(read.i64(168)),
            scl_slope: read.f64(176),
            scl_inter: read.f64(184),
            xyzt_units: read.i32(500),
            qform_code: read.i32(344),
            sform_code: read.i32(348),
            quatern: std::array::from_fn(|d| read.f64(352 + 8 * d)),
            qoffset: std::array::from_fn(|d| read.f64(376 + 8 * d)),
            srow: std::array::from_fn(|r| std::array::from_fn(|c| read.f64(400 + 32 * r + 8 * c))),
        })
    }
}

/// Numbers at offsets, in the header's byte order. Beyond the end everything is 0.
struct Reader<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl Reader<'_> {
    fn array<const N: usize>(&self, at: usize) -> [u8; N] {
        self.bytes.get(at..at + N).and_then(|b| b.try_into().ok()).unwrap_or([0; N])
    }

    fn i16(&self, at: usize) -> i16 {
        let b = self.array(at);
        if self.big { i16::from_be_bytes(b) } else { i16::from_le_bytes(b) }
    }

    fn i32(&self, at: usize) -> i32 {
        let b = self.array(at);
        if self.big { i32::from_be_bytes(b) } else { i32::from_le_bytes(b) }
    }

    fn i64(&self, at: usize) -> i64 {
        let b = self.array(at);
        if self.big { i64::from_be_bytes(b) } else { i64::from_le_bytes(b) }
    }

    fn f32(&self, at: usize) -> f32 {
        let b = self.array(at);
        if self.big { f32::from_be_bytes(b) } else { f32::from_le_bytes(b) }
    }

    fn f64(&self, at: usize) -> f64 {
        let b = self.array(at);
        if self.big { f64::from_be_bytes(b) } else { f64::from_le_bytes(b) }
    }
}
