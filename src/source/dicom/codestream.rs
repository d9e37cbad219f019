//! What the decoders of lossless JPEG and of JPEG-LS have in common: the frame that they give, and
//! what can be wrong with the codestream that they are given. Knows no process.

use super::bits::{Bits, Fault, Stuffing};
use super::segments::SegmentError;
use crate::error::{Failure, Kind};

/// A frame as it was coded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecodedFrame {
    /// Bits of a sample, 2 to 16: the codestream's own word, which may be less than DICOM's Bits
    /// Stored.
    pub bits: u8,
    /// Rows times columns, a row after the other; each below 2^`bits`.
    pub samples: Vec<u16>,
}

/// Why a frame does not decode. Rows count from 1, offsets in bytes from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CodestreamError {
    /// The marker segments.
    #[error(transparent)]
    Segment(#[from] SegmentError),
    /// A field outside the values that the standard allows.
    #[error("{field} is {found}, expected {least} to {most}")]
    Field {
        /// The field as the standard spells it.
        field: &'static str,
        /// The value.
        found: u32,
        /// The least allowed.
        least: u32,
        /// The most allowed.
        most: u32,
    },
    /// A part of the standard that is not decoded here.
    #[error("{what} ({value}) is a part of the standard that is not read")]
    Unsupported {
        /// Its name.
        what: &'static str,
        /// The value that asks for it.
        value: u32,
    },
    /// More components than the image has.
    #[error("the frame has {found} components, expected 1")]
    Components {
        /// The number of components.
        found: u8,
    },
    /// The codestream's own size is not that of the image it belongs to.
    #[error("the frame is {found_cols} x {found_rows}, expected {cols} x {rows}")]
    SizeMismatch {
        /// Lines in the codestream.
        found_rows: u32,
        /// Samples a line in the codestream.
        found_cols: u32,
        /// Rows expected.
        rows: usize,
        /// Columns expected.
        cols: usize,
    },
    /// More codes of a length than there can be.
    #[error("the Huffman table has {found} codes of {length} bits, where {most} are left")]
    TooManyCodes {
        /// Their length.
        length: u8,
        /// Codes of that length.
        found: u8,
        /// Codes of that length that the shorter ones leave.
        most: u32,
    },
    /// The scan asks for a table that no segment holds.
    #[error("the Huffman table {id} is not in the stream")]
    NoTable {
        /// Its number.
        id: u8,
    },
    /// Restart intervals that are not whole rows.
    #[error("restart markers every {interval} samples are not at the ends of rows of {cols}")]
    Interval {
        /// Samples between markers.
        interval: u16,
        /// Samples in a row.
        cols: usize,
    },
    /// The memory for the samples could not be had.
    #[error("no memory for {rows} rows of {cols} samples")]
    NoMemory {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        cols: usize,
    },
    /// The coded samples end early.
    #[error("the data end in row {row} of {rows}, after {bytes} bytes")]
    Truncated {
        /// The row that could not be finished.
        row: usize,
        /// Rows expected.
        rows: usize,
        /// All there is.
        bytes: usize,
    },
    /// A marker among the coded samples.
    #[error("marker {marker:04X} at byte {offset} ends the data in row {row} of {rows}")]
    EarlyMarker {
        /// The marker.
        marker: u16,
        /// Where.
        offset: usize,
        /// The row that could not be finished.
        row: usize,
        /// Rows expected.
        rows: usize,
    },
    /// A code that the process, or the table, does not have.
    #[error("the data are damaged in row {row} of {rows}, before byte {offset}")]
    BadCode {
        /// The row.
        row: usize,
        /// Rows expected.
        rows: usize,
        /// How far the data had been read.
        offset: usize,
    },
    /// A sample that its bits cannot hold.
    #[error("the data are damaged in row {row} of {rows}: a sample is {found}, the most is {most}")]
    Sample {
        /// The row.
        row: usize,
        /// Rows expected.
        rows: usize,
        /// The value.
        found: u16,
        /// The largest that P allows, after the point transform.
        most: u16,
    },
    /// No restart marker, or another one, where an interval ends.
    #[error("found {found:04X} after row {row}, expected restart marker {expected:04X}")]
    Restart {
        /// The last row of the interval.
        row: usize,
        /// What stands there, 0 where the data end.
        found: u16,
        /// The restart marker due.
        expected: u16,
    },
    /// Coded data that no row asks for.
    #[error("coded data are left over after row {row} of {rows}, before byte {offset}")]
    LeftOver {
        /// The last row of the interval.
        row: usize,
        /// Rows expected.
        rows: usize,
        /// How far the data had been read.
        offset: usize,
    },
}

impl Failure for CodestreamError {
    fn kind(&self) -> Kind {
        match self {
            Self::Segment(error) => error.kind(),
            Self::Unsupported { .. } => Kind::UnsupportedSyntax,
            Self::Truncated { .. } => Kind::TruncatedData,
            Self::NoMemory { .. } => Kind::TooLarge,
            _ => Kind::CorruptPixels,
        }
    }
}

/// Refuses what no header of either process can say.
///
/// # Errors
/// [`CodestreamError::Field`].
pub(super) fn check_size(rows: usize, cols: usize) -> Result<(), CodestreamError> {
    for (field, found) in [("Rows", rows), ("Columns", cols)] {
        if !(1..=0xFFFF).contains(&found) {
            let found = u32::try_from(found).unwrap_or(u32::MAX);
            return Err(CodestreamError::Field { field, found, least: 1, most: 0xFFFF });
        }
    }
    Ok(())
}

impl Fault {
    /// The fault as an error of the row that `bits` were read for.
    pub(super) fn at_row<S: Stuffing>(
        self,
        data: &[u8],
        bits: &Bits<'_, S>,
        row: usize,
        rows: usize,
    ) -> CodestreamError {
        let offset = bits.pos();
        match (self, data.get(offset..)) {
            (Self::Code, _) => CodestreamError::BadCode { row, rows, offset },
            (Self::End, Some(&[0xFF, second, ..])) => {
                let marker = 0xFF00 | u16::from(second);
                CodestreamError::EarlyMarker { marker, offset, row, rows }
            }
            (Self::End, _) => CodestreamError::Truncated { row, rows, bytes: data.len() },
        }
    }
}
