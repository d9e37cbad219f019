//! A lossless JPEG decoder (ITU-T T.81, process 14, SOF3): the bytes of one frame to its samples.
//!
//! All seven predictors, 2 to 16 bits, one component, point transform, restart markers. Several
//! components, several scans and lines counted after the samples are refused by name. It stands
//! between a DICOM frame's fragments, joined, and the samples as they are stored; it knows nothing
//! of DICOM and must never guess: damage that can be seen is an error, not an image.

mod bits;
mod header;
mod huffman;
mod scan;

use super::codestream::{CodestreamError, DecodedFrame, check_size};
use super::segments::restart;
use bits::Bits;
use header::Header;

/// Decodes one frame of `rows` rows of `cols` samples, 65 535 at most of either.
///
/// Whatever follows the end of the image is taken for padding; the marker of the end itself may
/// be missing.
///
/// # Errors
/// A stream that is cut, damaged, not lossless JPEG, of another size, or of a kind that is not
/// decoded.
///
/// # Cost
/// Holds two bytes a sample, which the caller holds against its limits, and a table of a few
/// thousand entries. One pass, and a second one where the point transform or P ask for it.
pub fn decode(data: &[u8], rows: usize, cols: usize) -> Result<DecodedFrame, CodestreamError> {
    let header = header::read(data, rows, cols)?;
    check_size(rows, cols)?;
    let no_memory = CodestreamError::NoMemory { rows, cols };
    let n = rows.checked_mul(cols).ok_or(no_memory)?;
    let mut samples = Vec::new();
    samples.try_reserve_exact(n).map_err(|_| no_memory)?;
    samples.resize(n, 0);
    let end = decode_rows(data, &header, (rows, cols), &mut samples)?;
    header::read_end(data, end)?;
    widen(&header, (rows, cols), &mut samples)?;
    Ok(DecodedFrame { bits: header.bits, samples })
}

/// Decodes all rows, interval after interval, and gives where the coded data end.
fn decode_rows(
    data: &[u8],
    header: &Header,
    (rows, cols): (usize, usize),
    samples: &mut [u16],
) -> Result<usize, CodestreamError> {
    let interval = header.interval.unwrap_or(rows);
    let mut bits = Bits::new(data, header.data_begin);
    let mut restarts = 0;
    let mut above: &[u16] = &[];
    for (line, row) in samples.chunks_exact_mut(cols).zip(1..) {
        let decoded = if above.is_empty() {
            scan::first_line(&mut bits, header, line)
        } else {
            scan::line(&mut bits, header, above, line)
        };
        decoded.map_err(|fault| fault.at_row(data, &bits, row, rows))?;
        above = line;
        let is_end = row % interval == 0;
        if (is_end || row == rows) && bits.finish().is_err() {
            return Err(CodestreamError::LeftOver { row, rows, offset: bits.pos() });
        }
        if is_end && row < rows {
            let begin = restart(data, bits.pos(), restarts)
                .map_err(|(found, expected)| CodestreamError::Restart { row, found, expected })?;
            bits = Bits::new(data, begin);
            above = &[];
            restarts = (restarts + 1) % 8;
        }
    }
    Ok(bits.pos())
}

/// Brings samples to P bits: undoes the point transform, and takes copies of the sign away that an
/// encoder of signed cells left above P.
///
/// # Errors
/// A sample that is more than P bits and no such copies.
fn widen(
    header: &Header,
    (rows, cols): (usize, usize),
    samples: &mut [u16],
) -> Result<(), CodestreamError> {
    let coded = u32::from(header.bits - header.point);
    let most = u16::MAX >> (16 - coded);
    let least_negative = !(most >> 1);
    let beyond = |&x: &u16| x > most && x < least_negative;
    if header.bits < 16 || header.point > 0 {
        for (line, row) in samples.chunks_exact_mut(cols).zip(1..) {
            if line.iter().fold(false, |any, x| any | beyond(x)) {
                let found = line.iter().copied().find(beyond).unwrap_or_default();
                return Err(CodestreamError::Sample { row, rows, found, most });
            }
            for x in line {
                *x = (*x & most) << header.point;
            }
        }
    }
    Ok(())
}
