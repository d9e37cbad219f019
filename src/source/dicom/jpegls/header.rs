//! The markers before and after the coded samples (T.87, annex C): what they say, checked. Decodes
//! no samples and allocates nothing.

use super::super::codestream::CodestreamError;
use super::super::segments::{DNL, DRI, EOI, SOS, Segments, is_idle, wrong_length};
use super::preset::{Coding, Preset};

const SOF55: u8 = 0xF7;
const LSE: u8 = 0xF8;

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

/// Reads from the start of `data` to the first byte of coded samples.
///
/// # Errors
/// A header that is cut, damaged, of another size than `rows` by `cols`, or asks for what is not
/// decoded here.
pub(super) fn read(data: &[u8], rows: usize, cols: usize) -> Result<Header, CodestreamError> {
    let mut segments = Segments::of_image(data)?;
    let mut frame = None;
    let mut preset = Preset::default();
    let mut interval = None;
    loop {
        let marker = segments.marker()?.ok_or_else(|| segments.cut())?;
        match marker {
            SOF55 if frame.is_none() => {
                frame = Some(read_frame(segments.content(marker)?, rows, cols)?);
            }
            LSE => preset = read_preset(segments.content(marker)?)?,
            DRI => interval = read_interval(segments.content(marker)?)?,
            SOS => {
                let content = segments.content(marker)?;
                let Some(Frame { bits, lines_follow }) = frame else {
                    return Err(segments.stray(marker).into());
                };
                let coding = Coding::new(bits, read_scan(content)?, preset)?;
                let data_begin = segments.pos();
                return Ok(Header { bits, coding, interval, lines_follow, data_begin });
            }
            _ if is_idle(marker) => {
                segments.content(marker)?;
            }
            _ => return Err(segments.unexpected(marker, SOF55).into()),
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
) -> Result<(), CodestreamError> {
    let mut segments = Segments::at(data, pos);
    while let Some(marker) = segments.marker()? {
        match marker {
            EOI => break,
            DNL => {
                let content = segments.content(marker)?;
                let found_rows = big_endian(content);
                if header.lines_follow && Some(found_rows) != u32::try_from(rows).ok() {
                    let found_cols = u32::try_from(cols).unwrap_or(u32::MAX);
                    return Err(CodestreamError::SizeMismatch {
                        found_rows,
                        found_cols,
                        rows,
                        cols,
                    });
                }
            }
            SOS => return Err(CodestreamError::Unsupported { what: "a second scan", value: 2 }),
            _ if is_idle(marker) || marker == LSE || marker == DRI => {
                segments.content(marker)?;
            }
            _ => return Err(segments.stray(marker).into()),
        }
    }
    Ok(())
}

/// At most four bytes as a number.
fn big_endian(bytes: &[u8]) -> u32 {
    bytes.iter().take(4).fold(0, |number, &b| number << 8 | u32::from(b))
}

/// T.87, C.2.2: P, Y, X, the number of components, and three bytes for each.
fn read_frame(content: &[u8], rows: usize, cols: usize) -> Result<Frame, CodestreamError> {
    let Some((&[bits, y1, y0, x1, x0, components], each)) = content.split_first_chunk::<6>() else {
        return Err(wrong_length(SOF55, content.len() + 2, 11).into());
    };
    if components != 1 {
        let value = u32::from(components);
        return Err(CodestreamError::Unsupported { what: "a number of components but 1", value });
    }
    if each.len() != 3 {
        return Err(wrong_length(SOF55, content.len() + 2, 11).into());
    }
    if !(2..=16).contains(&bits) {
        return Err(CodestreamError::Field { field: "P", found: bits.into(), least: 2, most: 16 });
    }
    let [found_rows, found_cols] = [[y1, y0], [x1, x0]].map(|b| u32::from(u16::from_be_bytes(b)));
    let lines_follow = found_rows == 0;
    let same = |found: u32, wanted: usize| usize::try_from(found) == Ok(wanted);
    if !(lines_follow || same(found_rows, rows)) || !same(found_cols, cols) {
        return Err(CodestreamError::SizeMismatch { found_rows, found_cols, rows, cols });
    }
    Ok(Frame { bits, lines_follow })
}

/// T.87, C.2.4.1: the preset parameters, the first of the kinds of LSE.
fn read_preset(content: &[u8]) -> Result<Preset, CodestreamError> {
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
    Err(CodestreamError::Unsupported { what, value: id.into() })
}

/// T.87, C.2.5: lines between restart markers, in two to four bytes; 0 for no such markers.
fn read_interval(content: &[u8]) -> Result<Option<u32>, CodestreamError> {
    match content.len() {
        2..=4 => Ok(Some(big_endian(content)).filter(|&lines| lines != 0)),
        other => Err(wrong_length(DRI, other + 2, 4).into()),
    }
}

/// T.87, C.2.3: gives NEAR.
fn read_scan(content: &[u8]) -> Result<u8, CodestreamError> {
    let Some((&components, rest)) = content.split_first() else {
        return Err(wrong_length(SOS, 2, 8).into());
    };
    if components != 1 {
        let value = u32::from(components);
        return Err(CodestreamError::Unsupported { what: "a scan of components but 1", value });
    }
    let &[_component, table, near, interleave, point] =
        rest.as_array::<5>().ok_or_else(|| wrong_length(SOS, content.len() + 2, 8))?;
    // One component is the same in every order of components.
    if interleave > 2 {
        let found = interleave.into();
        return Err(CodestreamError::Field { field: "ILV", found, least: 0, most: 2 });
    }
    for (what, value) in [("a mapping table", table), ("a point transform", point)] {
        if value != 0 {
            return Err(CodestreamError::Unsupported { what, value: value.into() });
        }
    }
    Ok(near)
}
