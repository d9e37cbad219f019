//! One element: tag, value representation, length. Every length is compared with what is left.

use dicom_core::dictionary::{DataDictionary, DataDictionaryEntry};
use dicom_object::StandardDataDictionary;

use super::blob::Stream;
use super::error::{FileFault, Tag};

/// A length that is given by a delimiter instead.
pub(super) const UNDEFINED: u32 = u32::MAX;

/// How elements are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Encoding {
    /// Each element names its VR.
    pub(super) explicit: bool,
    /// Numbers have their high byte first.
    pub(super) big: bool,
}

/// Whether two letters name a value representation.
pub(super) fn is_vr(vr: [u8; 2]) -> bool {
    const VRS: &[u8] = b"AEASATCSDADSDTFDFLISLOLTOBODOFOLOVOWPNSHSLSQSSSTSVTMUCUIULUNURUSUTUV";
    VRS.chunks_exact(2).any(|known| known == vr)
}

/// The VRs whose length takes four bytes after two unused ones (PS3.5, 7.1.2).
pub(super) fn has_long_length(vr: [u8; 2]) -> bool {
    const VRS: &[u8] = b"OBODOFOLOVOWSQSVUCUNURUTUV";
    VRS.chunks_exact(2).any(|long| long == vr)
}

/// The most that the first element of an item is believed to hold, where that is to say how the item
/// is written: the letters of a VR that is not known, taken for a length, are more.
const MOST_IN_FRONT: u64 = 0x1FFF;

/// How the elements of an item are written, as its first one looks: tools that do not know a
/// sequence copy its items as they are, whatever is written around them. `end` is where the item
/// ends, where that is given.
pub(super) fn item_encoding(
    stream: &mut Stream<'_>,
    around: Encoding,
    end: Option<u64>,
) -> Result<Encoding, FileFault> {
    let room = end.or_else(|| stream.left().map(|left| stream.at().saturating_add(left)));
    let room = room.map(|end| end.saturating_sub(stream.at()));
    if room.is_some_and(|room| room < 8) {
        return Ok(around);
    }
    let mut head = [0; 8];
    let n = stream.fill(&mut head).map_err(FileFault::io)?;
    stream.unread(head.get(..n).unwrap_or_default());
    let [g0, g1, _, _, rest @ ..] = head;
    // Delimiters never name a VR.
    if n < 8 || [g0, g1] == [0xFE, 0xFF] || [g0, g1] == [0xFF, 0xFE] {
        return Ok(around);
    }
    let length = if around.big { u32::from_be_bytes(rest) } else { u32::from_le_bytes(rest) };
    let names_vr = is_vr([rest[0], rest[1]]);
    let most = room.map_or(MOST_IN_FRONT, |room| MOST_IN_FRONT.min(room - 8));
    let fits = length == UNDEFINED || u64::from(length) <= most;
    Ok(Encoding { explicit: names_vr || (around.explicit && !fits), ..around })
}

/// The bytes of one value of a binary VR; 1 for text and bytes.
pub(super) fn value_bytes(vr: [u8; 2]) -> u32 {
    match &vr {
        b"US" | b"SS" | b"OW" => 2,
        b"UL" | b"SL" | b"FL" | b"OF" | b"OL" | b"AT" => 4,
        b"FD" | b"OD" | b"SV" | b"UV" | b"OV" => 8,
        _ => 1,
    }
}

/// The VR that the standard gives a tag; UN for a tag that is not in it.
pub(super) fn standard_vr(tag: Tag) -> [u8; 2] {
    let entry = StandardDataDictionary.by_tag(dicom_core::Tag(tag.0, tag.1));
    entry.map_or(*b"UN", |entry| entry.vr().relaxed().to_bytes())
}

/// Refuses a value whose length is no whole number of values of its VR: a parser that reads whole
/// values would go on in the middle of it, and take what it finds there for a length.
pub(super) fn check_whole(element: &Element) -> Result<(), FileFault> {
    if element.length.is_multiple_of(value_bytes(element.vr)) {
        return Ok(());
    }
    let what = "its length is no whole number of values";
    Err(FileFault::BadElement { tag: element.tag, what })
}

/// An element's tag, VR and length.
pub(super) struct Element {
    pub(super) tag: Tag,
    pub(super) vr: [u8; 2],
    pub(super) length: u32,
}

/// Reads up to an element's value; nothing at the end of the file.
pub(super) fn read_element(
    stream: &mut Stream<'_>,
    encoding: Encoding,
) -> Result<Option<Element>, FileFault> {
    let ends = |stream: &Stream<'_>| FileFault::HeaderEnds { at: stream.at() };
    let mut head = [0; 8];
    match stream.fill(&mut head).map_err(FileFault::io)? {
        0 => return Ok(None),
        8 => {}
        _ => return Err(ends(stream)),
    }
    let short =
        |a, b| if encoding.big { u16::from_be_bytes([a, b]) } else { u16::from_le_bytes([a, b]) };
    let long =
        |b: [u8; 4]| if encoding.big { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) };
    let [g0, g1, e0, e1, v0, v1, l0, l1] = head;
    let tag = Tag(short(g0, g1), short(e0, e1));
    // Items and delimiters never name a VR.
    if !encoding.explicit || tag.0 == 0xFFFE {
        return Ok(Some(Element { tag, vr: *b"  ", length: long([v0, v1, l0, l1]) }));
    }
    let vr = [v0, v1];
    if !is_vr(vr) {
        return Err(FileFault::BadElement { tag, what: "unknown value representation" });
    }
    if !has_long_length(vr) {
        return Ok(Some(Element { tag, vr, length: u32::from(short(l0, l1)) }));
    }
    let mut length = [0; 4];
    stream.take(&mut length).map_err(FileFault::io)?.ok_or_else(|| ends(stream))?;
    Ok(Some(Element { tag, vr, length: long(length) }))
}

/// The length of an element that must have one, checked against what is left.
pub(super) fn defined_length(element: &Element, stream: &Stream<'_>) -> Result<u64, FileFault> {
    let length = u64::from(element.length);
    if element.length == UNDEFINED {
        let what = "undefined length where a length is needed";
        return Err(FileFault::BadElement { tag: element.tag, what });
    }
    match stream.left() {
        Some(left) if left < length => {
            Err(FileFault::LengthBeyond { tag: element.tag, length, left })
        }
        _ => Ok(length),
    }
}

/// Passes over a value.
pub(super) fn skip(
    stream: &mut Stream<'_>,
    element: &Element,
    length: u64,
) -> Result<(), FileFault> {
    if stream.skip(length).map_err(FileFault::io)? {
        return Ok(());
    }
    let left = stream.left().unwrap_or(0);
    Err(FileFault::LengthBeyond { tag: element.tag, length, left })
}

/// Appends a value to `out`.
pub(super) fn append(
    stream: &mut Stream<'_>,
    length: u64,
    out: &mut Vec<u8>,
) -> Result<(), FileFault> {
    if stream.append(length, out).map_err(FileFault::io)? < length {
        return Err(FileFault::HeaderEnds { at: stream.at() });
    }
    Ok(())
}
