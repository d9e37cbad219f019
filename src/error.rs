//! What went wrong, for the caller: one line, a stable kind, and what to do about it.
//!
//! Each layer has an error enum of its own whose variants carry values. [`Failure`] is what they
//! have in common; [`Error`] adds the path at the boundary and is all that leaves the library.

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

/// The stable word for a failure, as `error.kind` in JSON has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// The input does not exist.
    NotFound,
    /// The input exists but the system would not let it be read.
    Unreadable,
    /// The content is of no format that is read here.
    UnknownFormat,
    /// A header field contradicts the format's standard.
    BadHeader,
    /// Dimensions that are zero, negative, or overflow.
    BadDims,
    /// A sample type that has no order (RGB, complex) or is not read.
    UnsupportedType,
    /// The data end before the header says.
    TruncatedData,
    /// A compressed stream that does not decode, or fails its checksum.
    CorruptCompression,
    /// A voxel-to-millimetre map that is not finite or not invertible.
    BadAffine,
    /// A raw file whose size does not fit its dimensions.
    SizeMismatch,
    /// More memory than the limits allow.
    TooLarge,
    /// No DICOM series that could be a volume.
    NoSeries,
    /// DICOM images that do not form a volume.
    UnfitSeries,
    /// A gap in a DICOM series that says that slices are missing.
    MissingSlices,
    /// Different DICOM images at one position.
    ConflictingSlices,
    /// A DICOM transfer syntax that is not decoded.
    UnsupportedSyntax,
    /// Compressed pixels that do not decode.
    CorruptPixels,
    /// The iso value lies outside the data, so there is no surface.
    IsoNotReached,
    /// More triangles or vertices than the output format can count.
    TooManyTriangles,
    /// Coordinates that 32-bit floats cannot tell apart.
    OutOfRangeSpace,
    /// The output exists already and may not be replaced.
    OutputExists,
    /// The output cannot be written.
    Unwritable,
    /// The run was asked to stop.
    Interrupted,
    /// A configuration file that cannot be used.
    BadConfig,
    /// A mistake of the program itself.
    Internal,
}

impl Kind {
    /// The word itself, such as `truncated-data`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::NotFound => "not-found",
            Self::Unreadable => "unreadable",
            Self::UnknownFormat => "unknown-format",
            Self::BadHeader => "bad-header",
            Self::BadDims => "bad-dims",
            Self::UnsupportedType => "unsupported-type",
            Self::TruncatedData => "truncated-data",
            Self::CorruptCompression => "corrupt-compression",
            Self::BadAffine => "bad-affine",
            Self::SizeMismatch => "size-mismatch",
            Self::TooLarge => "too-large",
            Self::NoSeries => "no-series",
            Self::UnfitSeries => "unfit-series",
            Self::MissingSlices => "missing-slices",
            Self::ConflictingSlices => "conflicting-slices",
            Self::UnsupportedSyntax => "unsupported-syntax",
            Self::CorruptPixels => "corrupt-pixels",
            Self::IsoNotReached => "iso-not-reached",
            Self::TooManyTriangles => "too-many-triangles",
            Self::OutOfRangeSpace => "out-of-range-space",
            Self::OutputExists => "output-exists",
            Self::Unwritable => "unwritable",
            Self::Interrupted => "interrupted",
            Self::BadConfig => "bad-config",
            Self::Internal => "internal",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A path or name as text. Bytes that are none are written `%FF`, so that names stay apart.
pub(crate) fn readable(name: impl AsRef<OsStr>) -> String {
    let mut text = String::new();
    for chunk in name.as_ref().as_encoded_bytes().utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().map(|byte| format!("%{byte:02X}")));
    }
    text
}

/// The system's error in words, in lower case and without its number.
pub(crate) fn system_words(error: &std::io::Error) -> String {
    if is_circle(error) {
        return "its symbolic links lead in a circle".to_owned();
    }
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or_default().to_lowercase()
}

/// Whether it is the system's error for symbolic links that lead in a circle, which the standard
/// library has no stable name for.
pub(crate) fn is_circle(error: &std::io::Error) -> bool {
    let code = if cfg!(windows) {
        1921
    } else if cfg!(any(target_os = "linux", target_os = "android")) {
        40
    } else {
        62
    };
    error.raw_os_error() == Some(code)
}

/// Whether it is the system's error for more open files than the process, or all, may have.
pub(crate) fn is_too_many_open(error: &std::io::Error) -> bool {
    let too_many = if cfg!(windows) { [4, 4] } else { [23, 24] };
    error.raw_os_error().is_some_and(|code| too_many.contains(&code))
}

/// What can be done about an error of the system.
pub(crate) fn system_hint(error: &std::io::Error) -> Option<&'static str> {
    is_too_many_open(error)
        .then_some("raise the limit (ulimit -n), or take fewer --threads and --jobs")
}

/// What every layer's error can say of itself. Its `Display` is one line in lower case, with the
/// value found and the value wanted, without the path.
pub trait Failure: std::error::Error + Send + Sync + 'static {
    /// The stable word for it.
    fn kind(&self) -> Kind;

    /// What the user can do, if anything, as one line.
    fn hint(&self) -> Option<String> {
        None
    }
}

/// The error of the library: a layer's failure, and the path it is about.
#[derive(Debug)]
pub struct Error {
    path: Option<PathBuf>,
    failure: Box<dyn Failure>,
}

impl Error {
    /// A failure that is about no file in particular.
    pub fn new(failure: impl Failure) -> Self {
        Self { path: None, failure: Box::new(failure) }
    }

    /// A failure about the file or folder at `path`.
    pub fn at(path: impl Into<PathBuf>, failure: impl Failure) -> Self {
        Self { path: Some(path.into()), failure: Box::new(failure) }
    }

    /// The same failure, said to be about `path` unless a more precise path is known already.
    #[must_use]
    pub fn or_at(mut self, path: &Path) -> Self {
        self.path.get_or_insert_with(|| path.to_owned());
        self
    }

    /// The stable word for it.
    pub fn kind(&self) -> Kind {
        self.failure.kind()
    }

    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        self.failure.hint()
    }

    /// The file or folder it is about.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            Some(path) => write!(f, "{}: {}", readable(path), self.failure),
            None => write!(f, "{}", self.failure),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.failure.source()
    }
}
