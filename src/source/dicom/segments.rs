//! The marker segments of the JPEG family (ITU-T T.81, B.1.1): a walk over them that reads what they
//! hold and knows no process.

use crate::error::{Failure, Kind};

/// Start of image.
pub(super) const SOI: u8 = 0xD8;
/// End of image.
pub(super) const EOI: u8 = 0xD9;
/// Start of scan.
pub(super) const SOS: u8 = 0xDA;
/// Number of lines.
pub(super) const DNL: u8 = 0xDC;
/// Restart interval.
pub(super) const DRI: u8 = 0xDD;

/// What can be wrong with the segments of a stream. Offsets in bytes from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SegmentError {
    /// The frame does not begin with the marker that begins every JPEG stream.
    #[error("the frame begins with {found:04X}, not with JPEG's FFD8")]
    NotJpeg {
        /// The first two bytes, 0 where there are none.
        found: u16,
    },
    /// The stream ends before its first sample.
    #[error("the header ends after {bytes} bytes, before the first sample")]
    HeaderCut {
        /// All there is.
        bytes: usize,
    },
    /// Something else where a marker belongs.
    #[error("found {found:02X} at byte {offset}, where a JPEG marker belongs")]
    NoMarker {
        /// Where.
        offset: usize,
        /// What stands there.
        found: u8,
    },
    /// A marker that has no place where it stands.
    #[error("marker {marker:04X} at byte {offset} has no place there")]
    StrayMarker {
        /// The marker.
        marker: u16,
        /// Where.
        offset: usize,
    },
    /// A marker segment whose length does not fit its content.
    #[error("the segment of marker {marker:04X} is {found} bytes long, expected {expected}")]
    Length {
        /// The segment's marker.
        marker: u16,
        /// The length it gives.
        found: usize,
        /// The length of its content, or the least it could be.
        expected: usize,
    },
    /// Another process of the JPEG family.
    #[error("the frame has marker {marker:04X} ({name}), expected {expected:04X}")]
    OtherProcess {
        /// The start-of-frame marker.
        marker: u16,
        /// What it is.
        name: &'static str,
        /// The marker of the process that is decoded.
        expected: u16,
    },
}

impl Failure for SegmentError {
    fn kind(&self) -> Kind {
        match self {
            Self::OtherProcess { .. } => Kind::UnsupportedSyntax,
            Self::HeaderCut { .. } => Kind::TruncatedData,
            _ => Kind::CorruptPixels,
        }
    }
}

/// A walk over marker segments.
pub(super) struct Segments<'a> {
    data: &'a [u8],
    pos: usize,
}

impl<'a> Segments<'a> {
    /// From the marker that begins an image on.
    ///
    /// # Errors
    /// Another beginning.
    pub(super) fn of_image(data: &'a [u8]) -> Result<Self, SegmentError> {
        match data.first_chunk::<2>() {
            Some([0xFF, SOI]) => Ok(Self { data, pos: 2 }),
            Some(&other) => Err(SegmentError::NotJpeg { found: u16::from_be_bytes(other) }),
            None => Err(SegmentError::HeaderCut { bytes: data.len() }),
        }
    }

    /// From the marker at `pos` on.
    pub(super) fn at(data: &'a [u8], pos: usize) -> Self {
        Self { data, pos }
    }

    /// The byte after what has been read.
    pub(super) fn pos(&self) -> usize {
        self.pos
    }

    /// The error of data that end here.
    pub(super) fn cut(&self) -> SegmentError {
        SegmentError::HeaderCut { bytes: self.data.len() }
    }

    /// The error of a marker, just read, that has no place here.
    pub(super) fn stray(&self, marker: u8) -> SegmentError {
        SegmentError::StrayMarker { marker: word(marker), offset: self.pos.saturating_sub(2) }
    }

    /// The error of a marker, just read, that is neither `expected` nor has a place here.
    pub(super) fn unexpected(&self, marker: u8, expected: u8) -> SegmentError {
        match process(marker) {
            Some(name) if marker != expected => {
                SegmentError::OtherProcess { marker: word(marker), name, expected: word(expected) }
            }
            _ => self.stray(marker),
        }
    }

    /// The next marker's second byte, past any FF that fills; `None` at the end of the data.
    ///
    /// # Errors
    /// Something else than a marker.
    pub(super) fn marker(&mut self) -> Result<Option<u8>, SegmentError> {
        match self.data.get(self.pos) {
            Some(0xFF) => {}
            Some(&found) => return Err(SegmentError::NoMarker { offset: self.pos, found }),
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
    ///
    /// # Errors
    /// A length that cannot be, or that reaches beyond the data.
    pub(super) fn content(&mut self, marker: u8) -> Result<&'a [u8], SegmentError> {
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

/// The error of a segment of `found` bytes, its length among them.
pub(super) fn wrong_length(marker: u8, found: usize, expected: usize) -> SegmentError {
    SegmentError::Length { marker: word(marker), found, expected }
}

fn word(marker: u8) -> u16 {
    0xFF00 | u16::from(marker)
}

/// Application data and comments, which say nothing of the samples of one component.
pub(super) fn is_idle(marker: u8) -> bool {
    matches!(marker, 0xE0..=0xEF | 0xFE)
}

/// Where the data go on after the restart marker at `pos`, the one numbered `number`, past any FF
/// that fills.
///
/// # Errors
/// What stands there instead (0 where the data end) and the marker that is due.
pub(super) fn restart(data: &[u8], pos: usize, number: u16) -> Result<usize, (u16, u16)> {
    let rest = data.get(pos..).unwrap_or_default();
    let fill = rest.iter().take_while(|&&b| b == 0xFF).count();
    let found = rest.get(fill).filter(|_| fill > 0).map_or(0, |&b| word(b));
    let expected = 0xFFD0 | number;
    if found == expected { Ok(pos + fill + 1) } else { Err((found, expected)) }
}

/// The process that a start-of-frame marker names (T.81, table B.1; T.87; T.870; T.800).
fn process(marker: u8) -> Option<&'static str> {
    Some(match marker {
        0xC0 => "baseline JPEG",
        0xC1 => "extended JPEG",
        0xC2 => "progressive JPEG",
        0xC3 => "lossless JPEG",
        0xC5..=0xC7 => "hierarchical JPEG",
        0xC9..=0xCB | 0xCD..=0xCF => "arithmetic-coded JPEG",
        0xF7 => "JPEG-LS",
        0xF9 => "JPEG-LS extended",
        0x4F | 0x51 => "JPEG 2000",
        _ => return None,
    })
}
