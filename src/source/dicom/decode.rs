//! Compressed frames to stored bytes: one frame at a time, its size checked before a decoder sees
//! it, foreign decoders behind the guard.

use std::io::Read;

use super::codestream::DecodedFrame;
use super::error::FileFault;
use super::layout::Layout;
use super::syntax::{self, Codec};
use super::{codec, jpegls, ljpeg, rle};

/// How the bytes of a frame are to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    /// Bits of a decoded sample, in the low bits, where a decoder tells; nothing where bits lie as
    /// the file's attributes say.
    pub(super) precision: Option<u32>,
    /// The decoder may give values a little beyond those that were encoded.
    pub(super) lossy: bool,
    /// Where samples of one bit stand eight in a byte: bits of the first byte that belong to the
    /// frame before. Nothing where each has a byte of its own.
    pub(super) packed: Option<u32>,
    /// High byte first.
    pub(super) big: bool,
}

/// Whether a fragment begins a compressed image: the first bytes of JPEG, JPEG-LS or JPEG 2000.
pub(super) fn begins_image(head: [u8; 4]) -> bool {
    matches!(head, [0xFF, 0xD8, 0xFF, _] | [0xFF, 0x4F, 0xFF, 0x51])
}

/// Bytes of one frame that stands alone.
fn frame_bytes(layout: &Layout) -> u64 {
    layout.native_bytes(1).unwrap_or(u64::MAX)
}

/// Inflates a frame (raw deflate), no further than its own size.
fn inflate(deflated: &[u8], layout: &Layout) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    flate2::read::DeflateDecoder::new(deflated).take(frame_bytes(layout)).read_to_end(&mut out)?;
    Ok(out)
}

/// Decodes one frame in place: `stored` holds its compressed bytes, and then its samples, low byte
/// first, in the layout's bytes a sample.
///
/// # Errors
/// [`FileFault::Syntax`], [`FileFault::Codec`], [`FileFault::Codestream`].
pub(super) fn decode(
    syntax: &str,
    layout: &Layout,
    stored: &mut Vec<u8>,
) -> Result<Image, FileFault> {
    let name = syntax::name(syntax);
    let fail = |detail: String| FileFault::Codec { syntax: name.to_owned(), detail };
    let damaged = |error| FileFault::Codestream { syntax: name.to_owned(), error };
    let Some(codec) = syntax::codec(syntax) else {
        return Err(FileFault::Syntax { uid: syntax.to_owned(), name: name.to_owned() });
    };
    let lossy = syntax::is_lossy(syntax);
    let image = |precision| Image { precision, lossy, packed: None, big: false };
    match codec {
        Codec::Rle => {
            *stored = rle::decode(stored, layout.n_samples(), layout.bytes)
                .map_err(|e| fail(e.to_string()))?;
            Ok(image(None))
        }
        Codec::Deflate => {
            *stored = inflate(stored, layout).map_err(|e| fail(super::blob::one_line(&e)))?;
            let (found, wanted) = (stored.len() as u64, frame_bytes(layout));
            if found < wanted {
                return Err(FileFault::PixelsEnd { found, wanted });
            }
            // Bits stay packed where bytes alone are compressed; other codecs take whole samples.
            Ok(Image { packed: Some(0), ..image(None) })
        }
        Codec::JpegLs => {
            let decoded = jpegls::decode(stored, layout.rows, layout.cols).map_err(damaged)?;
            store(&decoded, layout, stored).map_err(fail)?;
            Ok(image(Some(decoded.bits.into())))
        }
        Codec::Jpeg if codec::is_lossless_jpeg(syntax, stored) => {
            let decoded = ljpeg::decode(stored, layout.rows, layout.cols).map_err(damaged)?;
            store(&decoded, layout, stored).map_err(fail)?;
            Ok(Image { lossy: false, ..image(Some(sign_bits(decoded.bits, layout))) })
        }
        Codec::Jpeg | Codec::Jpeg2000 => {
            let lossy = lossy && !codec::is_reversible(stored);
            let (bytes, precision) = codec::decode(codec, layout, stored).map_err(fail)?;
            *stored = bytes;
            Ok(Image { lossy, ..image(Some(precision)) })
        }
    }
}

/// Puts a frame's samples in the place of its compressed bytes.
///
/// # Errors
/// More bits than a sample of the layout has.
fn store(frame: &DecodedFrame, layout: &Layout, stored: &mut Vec<u8>) -> Result<(), String> {
    let DecodedFrame { bits, samples } = frame;
    if usize::from(*bits).div_ceil(8) > layout.bytes {
        return Err(format!("it has {bits} bits, expected {}", layout.bytes * 8));
    }
    stored.clear();
    if layout.bytes == 1 {
        stored.extend(samples.iter().map(|&v| v as u8));
    } else {
        stored.extend(samples.iter().flat_map(|v| v.to_le_bytes()));
    }
    Ok(())
}

/// Bits of a sample of lossless JPEG, its sign among them, where P is `bits`.
///
/// Lossless JPEG knows no sign. Where P is less than `BitsStored`, the samples may all be positive or
/// have their sign in the highest of P bits; nothing in the file tells. GDCM, and so `SimpleITK`, goes
/// by its own widths of 8, 12 and 13 to 16 bits: the sign is in the highest of the first that holds P.
/// What they read is what the rest of a user's programs show.
fn sign_bits(bits: u8, layout: &Layout) -> u32 {
    let held = match bits {
        0..=8 => 8,
        9..=12 => 12,
        _ => u32::from(bits),
    };
    held.min(layout.bits_stored).max(bits.into())
}
