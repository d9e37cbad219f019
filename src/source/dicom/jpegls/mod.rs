//! A JPEG-LS decoder (ITU-T T.87, ISO/IEC 14495-1): the bytes of one frame to its samples.
//!
//! Lossless and near-lossless, 2 to 16 bits, one component, preset parameters, restart markers.
//! Several components, mapping tables and the extensions are refused by name. It stands between a
//! DICOM frame's fragments, joined, and the samples as they are stored; it knows nothing of DICOM
//! and must never guess: damage that can be seen is an error, not an image.

mod bits;
mod context;
mod header;
mod preset;
mod scan;

use super::codestream::{CodestreamError, DecodedFrame, check_size};
use super::segments::restart;
use bits::Bits;
use header::Header;
use scan::Scan;

/// Decodes one frame of `rows` rows of `cols` samples, 65 535 at most of either. A signed sample has
/// its sign in the highest of its bits.
///
/// Whatever follows the end of the image is taken for padding; the marker of the end itself may
/// be missing.
///
/// # Errors
/// A stream that is cut, damaged, not JPEG-LS, of another size, or of a kind that is not decoded.
///
/// # Cost
/// Holds two bytes a sample, which the caller holds against its limits, and a few lines. One pass.
pub fn decode(data: &[u8], rows: usize, cols: usize) -> Result<DecodedFrame, CodestreamError> {
    let header = header::read(data, rows, cols)?;
    let no_memory = CodestreamError::NoMemory { rows, cols };
    check_size(rows, cols)?;
    let mut samples = Vec::new();
    samples.try_reserve_exact(rows.checked_mul(cols).ok_or(no_memory)?).map_err(|_| no_memory)?;
    let mut scan = Scan::new(header.coding, cols).ok_or(no_memory)?;
    let end = decode_rows(data, &header, rows, &mut scan, &mut samples)?;
    header::read_end(data, end, &header, (rows, cols))?;
    Ok(DecodedFrame { bits: header.bits, samples })
}

/// Appends all rows, interval after interval, and gives where the coded data end.
fn decode_rows(
    data: &[u8],
    header: &Header,
    rows: usize,
    scan: &mut Scan,
    samples: &mut Vec<u16>,
) -> Result<usize, CodestreamError> {
    let lines = header.interval.and_then(|n| usize::try_from(n).ok()).unwrap_or(rows);
    let mut bits = Bits::new(data, header.data_begin);
    let mut restarts = 0;
    for row in 1..=rows {
        let line = scan.line(&mut bits).map_err(|fault| fault.at_row(data, &bits, row, rows))?;
        // A sample is at most MAXVAL, which is at most 65 535.
        samples.extend(line.iter().map(|&sample| sample as u16));
        let ends = row == rows || row % lines == 0;
        if ends && bits.finish().is_err() {
            return Err(CodestreamError::LeftOver { row, rows, offset: bits.pos() });
        }
        if row < rows && row % lines == 0 {
            let begin = restart(data, bits.pos(), restarts)
                .map_err(|(found, expected)| CodestreamError::Restart { row, found, expected })?;
            bits = Bits::new(data, begin);
            scan.restart();
            restarts = (restarts + 1) % 8;
        }
    }
    Ok(bits.pos())
}
