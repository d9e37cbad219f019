//! What can be wrong with a JPEG-LS stream.

use super::super::segments::SegmentError;
use crate::error::{Failure, Kind};

/// Why a frame does not decode. Rows count from 1, offsets in bytes from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum JpegLsError {
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
    #[error("{what} ({value}) is a part of JPEG-LS that is not read")]
    Unsupported {
        /// Its name.
        what: &'static str,
        /// The value that asks for it.
        value: u32,
    },
    /// The stream's own size is not that of the image it belongs to.
    #[error(
        "the JPEG-LS stream holds {found_rows} rows of {found_cols}, expected {rows} rows of {cols}"
    )]
    SizeMismatch {
        /// Lines in the stream.
        found_rows: u32,
        /// Samples a line in the stream.
        found_cols: u32,
        /// Rows expected.
        rows: usize,
        /// Columns expected.
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
    #[error("the JPEG-LS data end in row {row} of {rows}, after {bytes} bytes")]
    Truncated {
        /// The row that could not be finished.
        row: usize,
        /// Rows expected.
        rows: usize,
        /// All there is.
        bytes: usize,
    },
    /// A marker among the coded samples.
    #[error("marker {marker:04X} at byte {offset} ends the JPEG-LS data in row {row} of {rows}")]
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
    /// A code that no encoder writes.
    #[error("the JPEG-LS data are damaged in row {row} of {rows}, before byte {offset}")]
    BadCode {
        /// The row.
        row: usize,
        /// Rows expected.
        rows: usize,
        /// How far the data had been read.
        offset: usize,
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

impl Failure for JpegLsError {
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
