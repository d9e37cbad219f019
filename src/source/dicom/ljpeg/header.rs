//! The markers before and after the coded samples (T.81, annex B): what they say, checked. Decodes
//! no samples.

use super::super::codestream::CodestreamError;
use super::super::segments::{DNL, DRI, EOI, SOS, Segments, is_idle, wrong_length};
use super::huffman::{Huffman, Table};

const SOF3: u8 = 0xC3;
const DHT: u8 = 0xC4;
const DQT: u8 = 0xDB;

/// All that the samples need to know.
pub(super) struct Header {
    /// P, bits of a sample, 2 to 16.
    pub(super) bits: u8,
    /// The predictor, 1 to 7.
    pub(super) predictor: u8,
    /// Low bits that are not coded, less than `bits`.
    pub(super) point: u8,
    pub(super) table: Huffman,
    /// Rows between restart markers.
    pub(super) interval: Option<usize>,
    /// Where the coded data begin.
    pub(super) data_begin: usize,
}

/// Reads from the start of `data` to the first byte of coded samples.
///
/// # Errors
/// A header that is cut, damaged, of another size than `rows` by `cols`, or asks for what is not
/// decoded here.
pub(super) fn read(data: &[u8], rows: usize, cols: usize) -> Result<Header, CodestreamError> {
    let mut segments = Segments::of_image(data)?;
    let mut frame = None;
    let mut tables = [None; 4];
    let mut interval = 0;
    loop {
        let marker = segments.marker()?.ok_or_else(|| segments.cut())?;
        match marker {
            SOF3 if frame.is_none() => {
                frame = Some(read_frame(segments.content(marker)?, rows, cols)?);
            }
            DHT => read_tables(segments.content(marker)?, &mut tables)?,
            DRI => {
                let content = segments.content(marker)?;
                let wrong = || wrong_length(marker, content.len() + 2, 4);
                interval = u16::from_be_bytes(*content.as_array::<2>().ok_or_else(wrong)?);
            }
            SOS => {
                let content = segments.content(marker)?;
                let bits = frame.ok_or_else(|| segments.stray(marker))?;
                let (id, predictor, point) = read_scan(content, bits)?;
                let table = tables.get(usize::from(id)).copied().flatten();
                let table = Huffman::new(table.ok_or(CodestreamError::NoTable { id })?)?;
                let interval = whole_rows(interval, cols)?;
                let data_begin = segments.pos();
                return Ok(Header { bits, predictor, point, table, interval, data_begin });
            }
            _ if is_idle(marker) || marker == DQT => {
                segments.content(marker)?;
            }
            _ => return Err(segments.unexpected(marker, SOF3).into()),
        }
    }
}

/// Reads what follows the last sample, from the marker at `pos`: nothing, or segments to the end of
/// the image. What stands after that is padding.
///
/// # Errors
/// Another scan, or no marker at all.
pub(super) fn read_end(data: &[u8], pos: usize) -> Result<(), CodestreamError> {
    let mut segments = Segments::at(data, pos);
    while let Some(marker) = segments.marker()? {
        match marker {
            EOI => break,
            // One after the last interval too.
            0xD0..=0xD7 => {}
            SOS => {
                return Err(CodestreamError::Unsupported { what: "a second scan", value: 2 });
            }
            DHT | DRI | DNL => _ = segments.content(marker)?,
            _ if is_idle(marker) => _ = segments.content(marker)?,
            _ => return Err(segments.stray(marker).into()),
        }
    }
    Ok(())
}

/// T.81, B.2.2: P, Y, X, the number of components, and three bytes for each. Gives P.
fn read_frame(content: &[u8], rows: usize, cols: usize) -> Result<u8, CodestreamError> {
    let Some((&[bits, y1, y0, x1, x0, components], each)) = content.split_first_chunk::<6>() else {
        return Err(wrong_length(SOF3, content.len() + 2, 11).into());
    };
    if components != 1 {
        return Err(CodestreamError::Components { found: components });
    }
    if each.len() != 3 {
        return Err(wrong_length(SOF3, content.len() + 2, 11).into());
    }
    within("P", bits, 2, 16)?;
    let [found_rows, found_cols] = [[y1, y0], [x1, x0]].map(|b| u32::from(u16::from_be_bytes(b)));
    if found_rows == 0 {
        let what = "a number of lines that follows the samples (DNL), Y";
        return Err(CodestreamError::Unsupported { what, value: 0 });
    }
    let same = |found: u32, wanted: usize| usize::try_from(found) == Ok(wanted);
    if !same(found_rows, rows) || !same(found_cols, cols) {
        return Err(CodestreamError::SizeMismatch { found_rows, found_cols, rows, cols });
    }
    Ok(bits)
}

/// T.81, B.2.4.2: tables, of which those for differences (class 0) are kept.
fn read_tables<'a>(
    mut content: &'a [u8],
    tables: &mut [Option<Table<'a>>; 4],
) -> Result<(), CodestreamError> {
    let length = content.len() + 2;
    while !content.is_empty() {
        let (class, id, table, rest) =
            Table::split(content).ok_or_else(|| wrong_length(DHT, length, length + 1))?;
        within("Tc", class, 0, 1)?;
        within("Th", id, 0, 3)?;
        if let Some(slot) = tables.get_mut(usize::from(id)).filter(|_| class == 0) {
            *slot = Some(table);
        }
        content = rest;
    }
    Ok(())
}

/// T.81, B.2.3: gives the table's number, the predictor and the point transform.
fn read_scan(content: &[u8], bits: u8) -> Result<(u8, u8, u8), CodestreamError> {
    let Some((&components, rest)) = content.split_first() else {
        return Err(wrong_length(SOS, 2, 8).into());
    };
    if components != 1 {
        return Err(CodestreamError::Components { found: components });
    }
    let &[_component, tables, predictor, _end, point] =
        rest.as_array::<5>().ok_or_else(|| wrong_length(SOS, content.len() + 2, 8))?;
    within("Ss", predictor, 1, 7)?;
    let point = point & 0xF;
    within("Pt", point, 0, bits - 1)?;
    Ok((tables >> 4, predictor, point))
}

/// The rows of a restart interval, which is whole rows (T.81, H.1.1); 0 for no such markers.
fn whole_rows(interval: u16, cols: usize) -> Result<Option<usize>, CodestreamError> {
    let samples = usize::from(interval);
    if samples == 0 {
        return Ok(None);
    }
    match samples.checked_rem(cols) {
        Some(0) => Ok(Some(samples / cols)),
        _ => Err(CodestreamError::Interval { interval, cols }),
    }
}

fn within(field: &'static str, found: u8, least: u8, most: u8) -> Result<(), CodestreamError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    let [found, least, most] = [found, least, most].map(u32::from);
    Err(CodestreamError::Field { field, found, least, most })
}
