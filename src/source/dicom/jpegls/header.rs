//! The markers before and after the coded samples (T.87, annex C): what they say, checked. Decodes
//! no samples and allocates nothing.

use super::JpegLsError;
use super::preset::{Coding, Preset};

const SOI: u8 = 0xD8;
const EOI: u8 = 0xD9;
const SOS: u8 = 0xDA;
const DNL: u8 = 0xDC;
const DRI: u8 = 0xDD;
const SOF55: u8 = 0xF7;
const LSE: u8 = 0xF8;
const COM: u8 = 0xFE;

/// All that the samples need to know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    /// Bits of a sample, 2 to 16.
    pub(super) bits: u8,
    pub(super) coding: Coding,
    /// Lines between restart markers.
    pub(super) interval: Option<u32>,
    /// The number of lines follows the samples, in a DNL segment.
    pub(super) lines_follow: bool,
    /// Where the coded data begin.
    pub(super) data_begin: usize,
}

/// The frame header (T.87, C.2.2).
#[derive(Clone, Copy)]
struct Frame {
    bits: u8,
    lines_follow: bool,
}

/// A walk over marker segments.
struct Segments<'a> {
    data: &'a [u8],
    pos: usize,
}

impl<'a> Segments<'a> {
    fn cut(&self) -> JpegLsError {
        JpegLsError::HeaderCut { bytes: self.data.len() }
    }

    /// The next marker's second byte, past any FF that fills; `None` at the end of the data.
    fn marker(&mut self) -> Result<Option<u8>, JpegLsError> {
        match self.data.get(self.pos) {
            Some(0xFF) => {}
            Some(&found) => return Err(JpegLsError::NoMarker { offset: self.pos, found }),
            None => return Ok(None),
        }
        let rest = self.data.get(self.pos..).unwrap_or_default();
        let Some(fill) = rest.iter().position(|&b| b != 0xFF) else {
            self.pos = self.data.len();
            return Ok(None);
        };
        self.pos += fill + 1;
        Ok(rest.get(fill).copied())
    }

    /// The content of the segment of `marker`, without its length.
    fn content(&mut self, marker: u8) -> Result<&'a [u8], JpegLsError> {
        let rest = self.data.get(self.pos..).unwrap_or_default();
        let [high, low] = *rest.first_chunk::<2>().ok_or_else(|| self.cut())?;
        let length = usize::from(u16::from_be_bytes([high, low]));
        if length < 2 {
            return Err(wrong_length(marker, length, 2));
        }
        let content = rest.get(2..length).ok_or_else(|| self.cut())?;
        self.pos += length;
        Ok(content)
    }
}

fn word(marker: u8) -> u16 {
    0xFF00 | u16::from(marker)
}

fn wrong_length(marker: u8, found: usize, expected: usize) -> JpegLsError {
    JpegLsError::SegmentLength { marker: word(marker), found, expected }
}

/// Application data and comments, which say nothing of the samples of one component.
fn is_idle(marker: u8) -> bool {
    matches!(marker, 0xE0..=0xEF | COM)
}

/// Reads from the start of `data` to the first byte of coded samples.
///
/// # Errors
/// A header that is cut, damaged, of another size than `rows` by `cols`, or asks for what is not
/// decoded here.
pub(super) fn read(data: &[u8], rows: usize, cols: usize) -> Result<Header, JpegLsError> {
    match data.first_chunk::<2>() {
        Some([0xFF, SOI]) => {}
        Some(&other) => return Err(JpegLsError::NotJpeg { found: u16::from_be_bytes(other) }),
        None => return Err(JpegLsError::HeaderCut { bytes: data.len() }),
    }
    let mut segments = Segments { data, pos: 2 };
    let mut frame = None;
    let mut preset = Preset::default();
    let mut interval = None;
    loop {
        let marker = segments.marker()?.ok_or_else(|| segments.cut())?;
        let offset = segments.pos.saturating_sub(2);
        match marker {
            SOF55 if frame.is_none() => {
                frame = Some(read_frame(segments.content(marker)?, rows, cols)?);
            }
            LSE => preset = read_preset(segments.content(marker)?)?,
            DRI => interval = read_interval(segments.content(marker)?)?,
            SOS => {
                let content = segments.content(marker)?;
                let Some(Frame { bits, lines_follow }) = frame else {
                    return Err(JpegLsError::StrayMarker { marker: word(marker), offset });
                };
                let coding = Coding::new(bits, read_scan(content)?, preset)?;
                let data_begin = segments.pos;
                return Ok(Header { bits, coding, interval, lines_follow, data_begin });
            }
            _ if is_idle(marker) => {
                segments.content(marker)?;
            }
            _ => {
                return Err(match other_process(marker) {
                    Some(name) => JpegLsError::OtherProcess { marker: word(marker), name },
                    None => JpegLsError::StrayMarker { marker: word(marker), offset },
                });
            }
        }
    }
}

/// Reads what follows the last sample, from the marker at `pos`: nothing, or segments to the end of
/// the image. What stands after that is padding.
///
/// # Errors
/// Another scan, another number of lines, or no marker at all.
pub(super) fn read_end(
    data: &[u8],
    pos: usize,
    header: &Header,
    (rows, cols): (usize, usize),
) -> Result<(), JpegLsError> {
    let mut segments = Segments { data, pos };
    while let Some(marker) = segments.marker()? {
        let offset = segments.pos.saturating_sub(2);
        match marker {
            EOI => break,
            DNL => {
                let content = segments.content(marker)?;
                let found_rows = big_endian(content);
                if header.lines_follow && Some(found_rows) != u32::try_from(rows).ok() {
                    let found_cols = u32::try_from(cols).unwrap_or(u32::MAX);
                    return Err(JpegLsError::SizeMismatch { found_rows, found_cols, rows, cols });
                }
            }
            SOS => return Err(JpegLsError::Unsupported { what: "a second scan", value: 2 }),
            _ if is_idle(marker) || marker == LSE || marker == DRI => {
                segments.content(marker)?;
            }
            _ => return Err(JpegLsError::StrayMarker { marker: word(marker), offset }),
        }
    }
    Ok(())
}

/// At most four bytes as a number.
fn big_endian(bytes: &[u8]) -> u32 {
    bytes.iter().take(4).fold(0, |number, &b| number << 8 | u32::from(b))
}

/// T.87, C.2.2: P, Y, X, the number of components, and three bytes for each.
fn read_frame(content: &[u8], rows: usize, cols: usize) -> Result<Frame, JpegLsError> {
    let Some((&[bits, y1, y0, x1, x0, components], each)) = content.split_first_chunk::<6>() else {
        return Err(wrong_length(SOF55, content.len() + 2, 11));
    };
    if components != 1 {
        let value = u32::from(components);
        return Err(JpegLsError::Unsupported { what: "a number of components but 1", value });
    }
    if each.len() != 3 {
        return Err(wrong_length(SOF55, content.len() + 2, 11));
    }
    if !(2..=16).contains(&bits) {
        return Err(JpegLsError::Field { field: "P", found: bits.into(), least: 2, most: 16 });
    }
    let [found_rows, found_cols] = [[y1, y0], [x1, x0]].map(|b| u32::from(u16::from_be_bytes(b)));
    let lines_follow = found_rows == 0;
    let same = |found: u32, wanted: usize| usize::try_from(found) == Ok(wanted);
    if !(lines_follow || same(found_rows, rows)) || !same(found_cols, cols) {
        return Err(JpegLsError::SizeMismatch { found_rows, found_cols, rows, cols });
    }
    Ok(Frame { bits, lines_follow })
}

/// T.87, C.2.4.1: the preset parameters, the first of the kinds of LSE.
fn read_preset(content: &[u8]) -> Result<Preset, JpegLsError> {
    let (&id, fields) = content.split_first().ok_or_else(|| wrong_length(LSE, 2, 13))?;
    let what = match id {
        1 => {
            let &[m1, m0, a1, a0, b1, b0, c1, c0, r1, r0] =
                fields.as_array::<10>().ok_or_else(|| wrong_length(LSE, content.len() + 2, 13))?;
            let [maxval, t1, t2, t3, reset] =
                [[m1, m0], [a1, a0], [b1, b0], [c1, c0], [r1, r0]].map(u16::from_be_bytes);
            return Ok(Preset { maxval, t1, t2, t3, reset });
        }
        2 | 3 => "a mapping table, LSE of type",
        4 => "an oversize image, LSE of type",
        _ => "an extension, LSE of type",
    };
    Err(JpegLsError::Unsupported { what, value: id.into() })
}

/// T.87, C.2.5: lines between restart markers, in two to four bytes; 0 for no such markers.
fn read_interval(content: &[u8]) -> Result<Option<u32>, JpegLsError> {
    match content.len() {
        2..=4 => Ok(Some(big_endian(content)).filter(|&lines| lines != 0)),
        other => Err(wrong_length(DRI, other + 2, 4)),
    }
}

/// T.87, C.2.3: gives NEAR.
fn read_scan(content: &[u8]) -> Result<u8, JpegLsError> {
    let Some((&components, rest)) = content.split_first() else {
        return Err(wrong_length(SOS, 2, 8));
    };
    if components != 1 {
        let value = u32::from(components);
        return Err(JpegLsError::Unsupported { what: "a scan of components but 1", value });
    }
    let &[_component, table, near, interleave, point] =
        rest.as_array::<5>().ok_or_else(|| wrong_length(SOS, content.len() + 2, 8))?;
    // One component is the same in every order of components.
    if interleave > 2 {
        let found = interleave.into();
        return Err(JpegLsError::Field { field: "ILV", found, least: 0, most: 2 });
    }
    for (what, value) in [("a mapping table", table), ("a point transform", point)] {
        if value != 0 {
            return Err(JpegLsError::Unsupported { what, value: value.into() });
        }
    }
    Ok(near)
}

/// Start-of-frame markers of the other processes (T.81, table B.1; T.870; T.800).
fn other_process(marker: u8) -> Option<&'static str> {
    Some(match marker {
        0xC0 => "baseline JPEG",
        0xC1 => "extended JPEG",
        0xC2 => "progressive JPEG",
        0xC3 => "lossless JPEG",
        0xC5..=0xC7 => "hierarchical JPEG",
        0xC9..=0xCB | 0xCD..=0xCF => "arithmetic-coded JPEG",
        0xF9 => "JPEG-LS extended",
        0x4F | 0x51 => "JPEG 2000",
        _ => return None,
    })
}
