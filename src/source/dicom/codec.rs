//! The codecs of other crates: lossy JPEG (`jpeg-decoder`) and JPEG 2000 (`jpeg2k` over `openjp2`), one
//! frame at a time. They are called directly, for `dicom-transfer-syntax-registry` refuses frames of
//! 16 MiB and more that are compressed to less than a 64th, as blank slices are.
//!
//! What a compressed image says of its size is compared with Rows and Columns before it reaches a
//! decoder, for they allocate what the image claims.

use super::blob::one_line;
use super::guard::contain;
use super::layout::Layout;
use super::syntax::{self, Codec};

/// Decodes a frame: its samples, low byte first, and their precision in bits.
///
/// # Errors
/// One line in the decoder's own words.
pub(super) fn decode(
    codec: Codec,
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
    if let Some((x, y)) = size.step.filter(|&step| step != (1, 1)) {
        return Err(format!("a component of every {x} x {y} samples (XRsiz, YRsiz) is not read"));
    }
    if size.precision == 0 || size.precision.div_ceil(8) as usize > layout.bytes {
        return Err(format!("it has {} bits, expected {}", size.precision, layout.bytes * 8));
    }
    let out = contain(|| match codec {
        Codec::Jpeg2000 => jpeg_2000(layout, bytes),
        _ => jpeg(layout, bytes),
    });
    Ok((out.ok_or("the decoder gave up")??, size.precision))
}

/// Decodes JPEG 2000 of one component.
fn jpeg_2000(layout: &Layout, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let image = jpeg2k::Image::from_bytes(bytes).map_err(|e| innermost(&e))?;
    let samples = image.components().first().map_or(&[][..], |component| component.data());
    // Their precision has been held against the layout: the low bytes are the whole sample.
    match layout.bytes {
        1 => gather(layout, samples.iter().map(|&v| [v as u8])),
        _ => gather(layout, samples.iter().map(|&v| (v as u16).to_le_bytes())),
    }
}

/// Decodes JPEG of one component and 8 bits.
fn jpeg(layout: &Layout, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let samples = jpeg_decoder::Decoder::new(bytes).decode().map_err(|e| innermost(&e))?;
    match layout.bytes {
        1 => gather(layout, samples.iter().map(|&v| [v])),
        _ => gather(layout, samples.iter().map(|&v| [v, 0])),
    }
}

/// The bytes of a frame's samples.
///
/// # Errors
/// Another number of samples than the layout has.
fn gather<const N: usize>(
    layout: &Layout,
    samples: impl ExactSizeIterator<Item = [u8; N]>,
) -> Result<Vec<u8>, String> {
    let (found, wanted) = (samples.len(), layout.n_samples());
    if found != wanted {
        return Err(format!("{found} of {wanted} samples come out"));
    }
    let mut out = Vec::new();
    out.try_reserve_exact(found * N).map_err(|_| format!("no memory for {found} samples"))?;
    out.extend(samples.flatten());
    Ok(out)
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
    /// Columns and rows of the image to one sample of the first component, in JPEG 2000.
    step: Option<(u64, u64)>,
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
                    step: None,
                });
            }
            // Scan data or the end before any frame header.
            0xDA | 0xD9 => return None,
            0x01 | 0xD0..=0xD8 => at += 2,
            _ => at = at.checked_add(2)?.checked_add(number(bytes, at + 2, 2)? as usize)?,
        }
    }
}

/// Whether a JPEG 2000 image was transformed without loss, as the lossy transfer syntax allows; false
/// of JPEG (ITU-T T.800, A.6.1: the last byte of the coding style).
pub(super) fn is_reversible(bytes: &[u8]) -> bool {
    let transform = || {
        let mut at = jpeg_2000_start(bytes)? + 2;
        loop {
            match number(bytes, at, 2)? {
                0xFF52 => return number(bytes, at + 13, 1),
                // The first tile begins: there was none.
                0xFF90 => return None,
                _ => at = at.checked_add(2)?.checked_add(number(bytes, at + 2, 2)? as usize)?,
            }
        }
    };
    transform() == Some(1)
}

/// Where the codestream of a JPEG 2000 image begins, bare or in a JP2 file.
fn jpeg_2000_start(bytes: &[u8]) -> Option<usize> {
    const START: [u8; 4] = [0xFF, 0x4F, 0xFF, 0x51];
    if bytes.starts_with(&START) {
        return Some(0);
    }
    bytes.get(..4096.min(bytes.len()))?.windows(4).position(|w| w == START)
}

/// The size marker of a JPEG 2000 codestream (ITU-T T.800, A.5.1).
fn jpeg_2000_size(bytes: &[u8]) -> Option<Size> {
    let at = jpeg_2000_start(bytes)? + 4;
    let long = |offset: usize| number(bytes, at + offset, 4);
    let (width, height, left, top) = (long(4)?, long(8)?, long(12)?, long(16)?);
    Some(Size {
        rows: height.checked_sub(top)?,
        cols: width.checked_sub(left)?,
        components: number(bytes, at + 36, 2)?,
        precision: (number(bytes, at + 38, 1)? as u32 & 0x7F) + 1,
        process: 0x51,
        step: Some((number(bytes, at + 39, 1)?, number(bytes, at + 40, 1)?)),
    })
}
