//! Where a file begins: preamble, file meta group, and how the data set after it is written.

use super::blob::Stream;
use super::element::{Encoding, append, defined_length, is_vr, item_encoding, read_element, skip};
use super::error::{FileFault, Tag};

pub(super) const EXPLICIT_LITTLE: &str = "1.2.840.10008.1.2.1";
pub(super) const IMPLICIT_LITTLE: &str = "1.2.840.10008.1.2";
pub(super) const EXPLICIT_BIG: &str = "1.2.840.10008.1.2.2";
pub(super) const DEFLATED: &str = "1.2.840.10008.1.2.1.99";

/// Whether the first bytes of a file look like DICOM: the mark after the preamble, or an element
/// of the first groups where a file begins without one.
pub(super) fn looks_like_dicom(head: &[u8]) -> bool {
    head.get(128..132) == Some(b"DICM") || starts_with_element(head)
}

/// A first element of group 2 or 8 with a small length: no other format begins like that. One of
/// group 8 that is big endian names its VR.
fn starts_with_element(head: &[u8]) -> bool {
    let Some(&[g0, g1, e0, e1, v0, v1, l0, l1]) = head.first_chunk::<8>() else { return false };
    let explicit = is_vr([v0, v1]);
    if is_big(head) {
        return u16::from_be_bytes([e0, e1]) <= MOST_FIRST;
    }
    let (group, element) = (u16::from_le_bytes([g0, g1]), u16::from_le_bytes([e0, e1]));
    if !matches!(group, 2 | 8) || element > MOST_FIRST {
        return false;
    }
    let implicit_length = u32::from_le_bytes([v0, v1, l0, l1]);
    explicit || (group == 8 && implicit_length <= 256 && implicit_length.is_multiple_of(2))
}

/// The highest number that a file's first element has in its group.
const MOST_FIRST: u16 = 0x1155;

/// Whether an element of group 8 that names its VR begins here, its high bytes first.
fn is_big(head: &[u8]) -> bool {
    matches!(head, &[0, 8, _, _, v0, v1, ..] if is_vr([v0, v1]))
}

/// The transfer syntax of an uncompressed data set that is written so.
pub(super) fn syntax_of(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding { explicit: true, big: true } => EXPLICIT_BIG,
        Encoding { explicit: true, big: false } => EXPLICIT_LITTLE,
        Encoding { explicit: false, .. } => IMPLICIT_LITTLE,
    }
}

/// Passes the preamble. True where the file says that it is DICOM: by the mark, or by a meta group.
pub(super) fn find_start(stream: &mut Stream<'_>) -> Result<bool, FileFault> {
    let mut head = [0; 132];
    let n = stream.fill(&mut head).map_err(FileFault::io)?;
    let head = head.get(..n).unwrap_or_default();
    if head.get(128..132) == Some(b"DICM") {
        return Ok(true);
    }
    if !starts_with_element(head) {
        return Err(FileFault::NotDicom);
    }
    stream.unread(head);
    Ok(head.starts_with(&[2, 0]))
}

/// What the file meta group says.
#[derive(Default)]
pub(super) struct MetaGroup {
    pub(super) syntax: Option<String>,
    pub(super) media_class: Option<String>,
}

/// Reads the file meta group, if there is one. It is little endian, and explicit where its writer
/// keeps to the standard.
pub(super) fn read_meta(stream: &mut Stream<'_>) -> Result<MetaGroup, FileFault> {
    let mut meta = MetaGroup::default();
    let around = Encoding { explicit: true, big: false };
    loop {
        let mut group = [0; 2];
        let n = stream.fill(&mut group).map_err(FileFault::io)?;
        stream.unread(group.get(..n).unwrap_or_default());
        if n < 2 || u16::from_le_bytes(group) != 2 {
            return Ok(meta);
        }
        let encoding = item_encoding(stream, around, None)?;
        let Some(element) = read_element(stream, encoding)? else { return Ok(meta) };
        let length = defined_length(&element, stream)?;
        let wanted = match element.tag {
            Tag(2, 0x0010) => Some(&mut meta.syntax),
            Tag(2, 0x0002) => Some(&mut meta.media_class),
            _ => None,
        };
        match wanted {
            Some(to) if length <= 64 => {
                let mut value = Vec::new();
                append(stream, length, &mut value)?;
                let text: String = value.iter().map(|&b| char::from(b)).collect();
                *to = Some(text.trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_owned())
                    .filter(|t| !t.is_empty());
            }
            _ => skip(stream, &element, length)?,
        }
    }
}

/// How the data set is written: as the transfer syntax says, or, where its first element
/// contradicts that or there is none, as the first element looks.
pub(super) fn settle_encoding(
    stream: &mut Stream<'_>,
    syntax: Option<&str>,
) -> Result<Encoding, FileFault> {
    let mut head = [0; 6];
    let n = stream.fill(&mut head).map_err(FileFault::io)?;
    stream.unread(head.get(..n).unwrap_or_default());
    let names_vr = is_vr([head[4], head[5]]);
    Ok(match syntax {
        Some(EXPLICIT_BIG) => Encoding { explicit: true, big: true },
        None if is_big(&head) => Encoding { explicit: true, big: true },
        Some(IMPLICIT_LITTLE) | None => Encoding { explicit: names_vr, big: false },
        Some(_) => Encoding { explicit: names_vr || n < 6, big: false },
    })
}
