//! The codecs of `dicom-transfer-syntax-registry`: JPEG and JPEG 2000, one frame at a time.
//!
//! What a compressed image says of its size is compared with Rows and Columns before it reaches a
//! decoder, for they allocate what the image claims.

use std::borrow::Cow;

use dicom_core::smallvec::smallvec;
use dicom_encoding::adapters::{PixelDataObject, RawPixelData};
use dicom_encoding::{Codec as RegistryCodec, TransferSyntaxIndex};
use dicom_transfer_syntax_registry::TransferSyntaxRegistry;

use super::blob::one_line;
use super::guard::contain;
use super::layout::Layout;
use super::syntax::{self, Codec};

/// A single frame, as the registry's codecs want to see it.
#[derive(Debug)]
struct SingleFrame<'a> {
    syntax: &'a str,
    rows: u16,
    cols: u16,
    bits_allocated: u16,
    bits_stored: u16,
    bytes: &'a [u8],
}

impl PixelDataObject for SingleFrame<'_> {
    fn transfer_syntax_uid(&self) -> &str {
        self.syntax
    }

    fn rows(&self) -> Option<u16> {
        Some(self.rows)
    }

    fn cols(&self) -> Option<u16> {
        Some(self.cols)
    }

    fn samples_per_pixel(&self) -> Option<u16> {
        Some(1)
    }

    fn bits_allocated(&self) -> Option<u16> {
        Some(self.bits_allocated)
    }

    fn bits_stored(&self) -> Option<u16> {
        Some(self.bits_stored)
    }

    fn photometric_interpretation(&self) -> Option<&str> {
        Some("MONOCHROME2")
    }

    fn number_of_frames(&self) -> Option<u32> {
        Some(1)
    }

    fn number_of_fragments(&self) -> Option<u32> {
        Some(1)
    }

    fn fragment(&self, fragment: usize) -> Option<Cow<'_, [u8]>> {
        (fragment == 0).then_some(Cow::Borrowed(self.bytes))
    }

    fn offset_table(&self) -> Option<Cow<'_, [u32]>> {
        Some(Cow::Borrowed(&[]))
    }

    fn raw_pixel_data(&self) -> Option<RawPixelData> {
        Some(RawPixelData { fragments: smallvec![self.bytes.to_vec()], offset_table: smallvec![] })
    }
}

/// Decodes a frame: its samples, low byte first, and their precision in bits.
///
/// # Errors
/// One line in the decoder's own words.
pub(super) fn decode(
    codec: Codec,
    syntax: &str,
    layout: &Layout,
    bytes: &[u8],
) -> Result<(Vec<u8>, u32), String> {
    let size = match codec {
        Codec::Jpeg2000 => jpeg_2000_size(bytes),
        _ => jpeg_size(bytes),
    };
    let size = size.ok_or("no image header in it")?;
    let (rows, cols) = (layout.rows as u64, layout.cols as u64);
    if (size.rows, size.cols) != (rows, cols) {
        let (found_cols, found_rows) = (size.cols, size.rows);
        return Err(format!("it is {found_cols} x {found_rows}, expected {cols} x {rows}"));
    }
    if size.components != 1 {
        return Err(format!("it has {} components, expected 1", size.components));
    }
    if size.precision == 0 || size.precision.div_ceil(8) as usize > layout.bytes {
        return Err(format!("it has {} bits, expected {}", size.precision, layout.bytes * 8));
    }
    let frame = SingleFrame {
        syntax,
        rows: layout.rows as u16,
        cols: layout.cols as u16,
        bits_allocated: (layout.bytes * 8) as u16,
        bits_stored: layout.bits_stored as u16,
        bytes,
    };
    let registered = TransferSyntaxRegistry.get(syntax).ok_or("no decoder")?;
    let RegistryCodec::EncapsulatedPixelData(Some(reader), _) = registered.codec() else {
        return Err("no decoder".to_owned());
    };
    let mut out = Vec::new();
    contain(|| reader.decode_frame(&frame, 0, &mut out))
        .ok_or("the decoder gave up")?
        .map_err(|e| innermost(&e))?;
    let wanted = layout.frame_bytes();
    if out.len() < wanted {
        return Err(format!("{} of {wanted} bytes come out", out.len()));
    }
    // A decoder of up to 8 bits gives one byte a sample where two are allocated.
    if codec == Codec::Jpeg && size.precision <= 8 && layout.bytes == 2 {
        out = out.iter().take(layout.n_samples()).flat_map(|&b| [b, 0]).collect();
    }
    Ok((out, size.precision))
}

/// Whether a frame is one of lossless JPEG, whatever the transfer syntax says; what has no frame
/// header is what that says.
pub(super) fn is_lossless_jpeg(syntax: &str, bytes: &[u8]) -> bool {
    jpeg_size(bytes).map_or(syntax::is_lossless_jpeg(syntax), |size| size.process == 0xC3)
}

/// The last of a chain of causes: the one that says what is wrong.
fn innermost(error: &dyn std::error::Error) -> String {
    let mut error = error;
    while let Some(source) = error.source() {
        error = source;
    }
    let line = one_line(error);
    // What the JPEG 2000 decoder says of whatever it cannot read.
    if line.contains("Null pointer") {
        return "the codestream is damaged or cut short".to_owned();
    }
    line
}

/// What a compressed image says of itself.
struct Size {
    rows: u64,
    cols: u64,
    components: u64,
    precision: u32,
    /// The second byte of the marker that says so.
    process: u64,
}

fn number(bytes: &[u8], at: usize, len: usize) -> Option<u64> {
    let bytes = bytes.get(at..at.checked_add(len)?)?;
    Some(bytes.iter().fold(0, |n, &b| n << 8 | u64::from(b)))
}

/// The first frame header of a JPEG image (ITU-T T.81, B.2.2).
fn jpeg_size(bytes: &[u8]) -> Option<Size> {
    let mut at = bytes.starts_with(&[0xFF, 0xD8]).then_some(2)?;
    loop {
        if number(bytes, at, 1)? != 0xFF {
            return None;
        }
        let marker = number(bytes, at + 1, 1)?;
        match marker {
            // Fill bytes before a marker.
            0xFF => at += 1,
            0xC0..=0xCF if !matches!(marker, 0xC4 | 0xC8 | 0xCC) => {
                return Some(Size {
                    precision: number(bytes, at + 4, 1)? as u32,
                    rows: number(bytes, at + 5, 2)?,
                    cols: number(bytes, at + 7, 2)?,
                    components: number(bytes, at + 9, 1)?,
                    process: marker,
                });
            }
            // Scan data or the end before any frame header.
            0xDA | 0xD9 => return None,
            0x01 | 0xD0..=0xD8 => at += 2,
            _ => at = at.checked_add(2)?.checked_add(number(bytes, at + 2, 2)? as usize)?,
        }
    }
}

/// The size marker of a JPEG 2000 codestream (ITU-T T.800, A.5.1), bare or in a JP2 file.
fn jpeg_2000_size(bytes: &[u8]) -> Option<Size> {
    const START: [u8; 4] = [0xFF, 0x4F, 0xFF, 0x51];
    let start = if bytes.starts_with(&START) {
        0
    } else {
        bytes.get(..4096.min(bytes.len()))?.windows(4).position(|w| w == START)?
    };
    let at = start + 4;
    let long = |offset: usize| number(bytes, at + offset, 4);
    let (width, height, left, top) = (long(4)?, long(8)?, long(12)?, long(16)?);
    Some(Size {
        rows: height.checked_sub(top)?,
        cols: width.checked_sub(left)?,
        components: number(bytes, at + 36, 2)?,
        precision: (number(bytes, at + 38, 1)? as u32 & 0x7F) + 1,
        process: 0x51,
    })
}
