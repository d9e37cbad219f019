//! Transfer syntaxes: which are compressed, which are decoded, what they are called.

use super::error::FileFault;
use super::layout::Layout;

/// General Electric's own: everything little endian but the pixels.
const GE_PRIVATE: &str = "1.2.840.113619.5.2";
const JPEG_EXTENDED: &str = "1.2.840.10008.1.2.4.51";

/// The codec of a transfer syntax whose pixels are encapsulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    Rle,
    /// Each frame deflated by itself.
    Deflate,
    Jpeg,
    JpegLs,
    Jpeg2000,
}

/// Whether pixels stand in fragments. Anything unknown does, as the standard has it for whatever
/// is none of the four native syntaxes.
pub(super) fn is_encapsulated(syntax: &str) -> bool {
    !matches!(
        syntax,
        "1.2.840.10008.1.2"
            | "1.2.840.10008.1.2.1"
            | "1.2.840.10008.1.2.1.99"
            | "1.2.840.10008.1.2.2"
            | GE_PRIVATE
    )
}

/// Whether samples of several bytes have their high byte first, whatever the headers do.
pub(super) fn has_big_pixels(syntax: &str) -> bool {
    syntax == GE_PRIVATE
}

/// The codec, if it is one that is decoded.
pub(super) fn codec(syntax: &str) -> Option<Codec> {
    match syntax {
        "1.2.840.10008.1.2.5" => Some(Codec::Rle),
        "1.2.840.10008.1.2.8.1" => Some(Codec::Deflate),
        "1.2.840.10008.1.2.4.50"
        | JPEG_EXTENDED
        | "1.2.840.10008.1.2.4.57"
        | "1.2.840.10008.1.2.4.70" => Some(Codec::Jpeg),
        "1.2.840.10008.1.2.4.80" | "1.2.840.10008.1.2.4.81" => Some(Codec::JpegLs),
        "1.2.840.10008.1.2.4.90"
        | "1.2.840.10008.1.2.4.91"
        | "1.2.840.10008.1.2.4.201"
        | "1.2.840.10008.1.2.4.202"
        | "1.2.840.10008.1.2.4.203" => Some(Codec::Jpeg2000),
        _ => None,
    }
}

/// Whether the frames are lossless JPEG (process 14).
pub(super) fn is_lossless_jpeg(syntax: &str) -> bool {
    matches!(syntax, "1.2.840.10008.1.2.4.57" | "1.2.840.10008.1.2.4.70")
}

/// Whether an encoder may have changed the samples.
pub(super) fn is_lossy(syntax: &str) -> bool {
    matches!(
        syntax,
        "1.2.840.10008.1.2.4.50"
            | JPEG_EXTENDED
            | "1.2.840.10008.1.2.4.81"
            | "1.2.840.10008.1.2.4.91"
            | "1.2.840.10008.1.2.4.203"
    )
}

/// Why an encapsulated syntax is not decoded, if it is not.
pub(super) fn refuse(syntax: &str, layout: &Layout) -> Option<FileFault> {
    let decoded = match codec(syntax) {
        None => false,
        // The decoder takes 8 bits only in the lossy processes.
        Some(Codec::Jpeg) if syntax == JPEG_EXTENDED => layout.bits_stored <= 8,
        Some(Codec::Rle | Codec::Deflate) => true,
        Some(_) => layout.bytes <= 2,
    };
    (!decoded).then(|| FileFault::Syntax { uid: syntax.to_owned(), name: name(syntax).to_owned() })
}

/// A transfer syntax by the name people use.
pub(super) fn name(syntax: &str) -> &'static str {
    match syntax {
        "1.2.840.10008.1.2" => "implicit VR little endian",
        "1.2.840.10008.1.2.1" => "explicit VR little endian",
        "1.2.840.10008.1.2.1.99" => "deflated",
        "1.2.840.10008.1.2.2" => "explicit VR big endian",
        GE_PRIVATE => "GE private, big endian pixels",
        "1.2.840.10008.1.2.5" => "RLE",
        "1.2.840.10008.1.2.8.1" => "deflated frames",
        "1.2.840.10008.1.2.4.50" => "JPEG baseline",
        JPEG_EXTENDED => "JPEG extended, 12 bits",
        "1.2.840.10008.1.2.4.53" => "JPEG spectral selection",
        "1.2.840.10008.1.2.4.55" => "JPEG full progression",
        "1.2.840.10008.1.2.4.57" => "JPEG lossless, process 14",
        "1.2.840.10008.1.2.4.70" => "JPEG lossless SV1",
        "1.2.840.10008.1.2.4.80" => "JPEG-LS lossless",
        "1.2.840.10008.1.2.4.81" => "JPEG-LS near-lossless",
        "1.2.840.10008.1.2.4.90" => "JPEG 2000 lossless",
        "1.2.840.10008.1.2.4.91" => "JPEG 2000",
        "1.2.840.10008.1.2.4.92" | "1.2.840.10008.1.2.4.93" => "JPEG 2000 part 2",
        "1.2.840.10008.1.2.4.201" | "1.2.840.10008.1.2.4.202" | "1.2.840.10008.1.2.4.203" => {
            "HTJ2K"
        }
        "1.2.840.10008.1.2.4.110" | "1.2.840.10008.1.2.4.111" | "1.2.840.10008.1.2.4.112" => {
            "JPEG XL"
        }
        s if s.starts_with("1.2.840.10008.1.2.4.10") => "MPEG video",
        _ => "unknown",
    }
}

/// A transfer syntax in one or two words.
pub(super) fn short_name(syntax: &str) -> &'static str {
    match syntax {
        "1.2.840.10008.1.2" => "implicit LE",
        "1.2.840.10008.1.2.1" => "explicit LE",
        "1.2.840.10008.1.2.2" => "explicit BE",
        GE_PRIVATE => "GE private",
        "1.2.840.10008.1.2.4.50" => "JPEG",
        JPEG_EXTENDED => "JPEG 12 bit",
        "1.2.840.10008.1.2.4.57" | "1.2.840.10008.1.2.4.70" => "JPEG lossless",
        "1.2.840.10008.1.2.4.80" => "JPEG-LS",
        "1.2.840.10008.1.2.4.81" => "JPEG-LS near",
        "1.2.840.10008.1.2.4.90" | "1.2.840.10008.1.2.4.91" => "JPEG 2000",
        other => name(other),
    }
}
