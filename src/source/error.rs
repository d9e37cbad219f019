//! What can be wrong with an input.

use super::WrapError;
use super::nifti::NiftiError;
use super::raw::RawError;
use super::waiting::is_stopped;
use crate::error::{Failure, Kind, system_hint, system_words};
use crate::geom::DimsError;

/// A source's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The system's own error while reading.
    #[error("{}", describe(.0))]
    Io(#[source] std::io::Error),
    /// A folder where a file is wanted.
    #[error("is a folder, a file is wanted")]
    Folder,
    /// Content of no format that is read here; the name of what it looks like, where that is known.
    #[error("{}", match .0 {
        Some(name) => format!("looks like {name}, which is not read here"),
        None => "is neither NIfTI nor DICOM".to_owned(),
    })]
    UnknownFormat(Option<&'static str>),
    /// Dimensions that are no size of a volume.
    #[error(transparent)]
    Dims(#[from] DimsError),
    /// A NIfTI header that cannot be used.
    #[error(transparent)]
    Nifti(#[from] NiftiError),
    /// A raw file that does not fit what was said of it.
    #[error(transparent)]
    Raw(#[from] RawError),
    /// A volume that the file does not hold, counted from 1.
    #[error("volume {asked} was asked for, the file holds {of}")]
    NoSuchVolume {
        /// The number asked for.
        asked: usize,
        /// How many there are.
        of: usize,
    },
    /// The samples end before the header says.
    #[error(
        "the data end after {planes} of {of_planes} planes ({} of {} bytes)",
        grouped(*.bytes),
        grouped(*.of_bytes)
    )]
    Truncated {
        /// Whole planes that are there, over all volumes of the file.
        planes: u64,
        /// Planes that the header says there are.
        of_planes: u64,
        /// Bytes of samples that are there.
        bytes: u64,
        /// Bytes of samples that the header says there are.
        of_bytes: u64,
    },
    /// A gzip file too small for what the header in it claims, whatever the samples are.
    #[error(
        "the {} bytes of this gzip file cannot hold the {} bytes of samples that its header claims",
        grouped(*.compressed),
        grouped(*.of_bytes)
    )]
    TooSmallForGzip {
        /// The size of the compressed file.
        compressed: u64,
        /// Bytes of samples that the header says there are.
        of_bytes: u64,
    },
    /// A gzip stream that ends before its own end mark or checksum.
    #[error("the gzip stream is cut short after {} bytes of its content", grouped(*.after))]
    GzipCut {
        /// Bytes that were inflated.
        after: u64,
    },
    /// A gzip stream that does not decode, or fails its checksum.
    #[error("the gzip stream is damaged within {} bytes of its content: {reason}", grouped(*.after))]
    GzipDamaged {
        /// Bytes that were inflated.
        after: u64,
        /// What the decoder says.
        reason: String,
    },
    /// Not enough memory for one plane.
    #[error("{} bytes of memory for one plane are not to be had", grouped(*.bytes))]
    Memory {
        /// How many were asked for.
        bytes: u64,
    },
    /// A stop was asked for.
    #[error("interrupted")]
    Interrupted,
    /// A buffer that is not one contiguous plane.
    #[error("internal error: a plane buffer is not contiguous")]
    PlaneBuffer,
    /// A DICOM file or series.
    #[error(transparent)]
    Dicom(Box<super::dicom::DicomError>),
    /// A step that wraps a source cannot be taken.
    #[error(transparent)]
    Wrap(#[from] WrapError),
    /// Anything else: a stable kind, one line, and perhaps a hint. For layers whose own enums give
    /// the values; not to be used where a variant says more.
    #[error("{message}")]
    Other {
        /// The stable word.
        kind: Kind,
        /// One line.
        message: String,
        /// What to do.
        hint: Option<String>,
    },
}

impl From<std::io::Error> for SourceError {
    fn from(error: std::io::Error) -> Self {
        if is_stopped(&error) { Self::Interrupted } else { Self::Io(error) }
    }
}

impl Failure for SourceError {
    fn kind(&self) -> Kind {
        match self {
            Self::Io(e) if e.kind() == std::io::ErrorKind::NotFound => Kind::NotFound,
            Self::Io(_) | Self::Folder => Kind::Unreadable,
            Self::UnknownFormat(_) => Kind::UnknownFormat,
            Self::Dims(DimsError::PlaneTooLarge(..)) | Self::Memory { .. } => Kind::TooLarge,
            Self::Dims(_) | Self::NoSuchVolume { .. } => Kind::BadDims,
            Self::Nifti(e) => e.kind(),
            Self::Raw(e) => e.kind(),
            Self::Truncated { .. } | Self::TooSmallForGzip { .. } | Self::GzipCut { .. } => {
                Kind::TruncatedData
            }
            Self::GzipDamaged { .. } => Kind::CorruptCompression,
            Self::Interrupted => Kind::Interrupted,
            Self::PlaneBuffer => Kind::Internal,
            Self::Dicom(e) => e.kind(),
            Self::Wrap(e) => e.kind(),
            Self::Other { kind, .. } => *kind,
        }
    }

    fn hint(&self) -> Option<String> {
        let line = match self {
            Self::Truncated { .. } | Self::TooSmallForGzip { .. } | Self::GzipCut { .. } => {
                "the file was cut short; copy it again"
            }
            Self::GzipDamaged { .. } => "the file was damaged; copy it again",
            Self::Io(e) => return system_hint(e).map(str::to_owned),
            Self::Folder => "name a file in it; a folder of DICOM images is read as a whole",
            Self::UnknownFormat(_) => {
                "samples without a header are read with --dims and --type; see mcubes --help"
            }
            Self::NoSuchVolume { of, .. } => {
                return Some(format!("--volume takes a number from 1 to {of}"));
            }
            Self::Nifti(e) => return e.hint(),
            Self::Raw(e) => return e.hint(),
            Self::Wrap(e) => return e.hint(),
            Self::Dicom(e) => return e.hint(),
            Self::Other { hint, .. } => return hint.clone(),
            _ => return None,
        };
        Some(line.to_owned())
    }
}

/// The system's error in words, without its number.
pub(super) fn describe(error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::NotFound => "does not exist".to_owned(),
        ErrorKind::PermissionDenied => "cannot be read: permission denied".to_owned(),
        ErrorKind::IsADirectory => "is a folder, a file is wanted".to_owned(),
        _ => format!("cannot be read: {}", system_words(error)),
    }
}

/// A count with its thousands set apart: `26 214 400`.
pub(crate) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn counts_are_grouped_by_three() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1000), "1 000");
        assert_eq!(grouped(26_214_400), "26 214 400");
    }
}
