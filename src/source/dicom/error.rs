//! What can be wrong with a DICOM file, and with a series.

use std::sync::Arc;

use crate::error::{Failure, Kind};
use crate::limits::MAX_FRAMES_BYTES;

/// What is wrong with one file. Cloned freely: one fault may speak for several series.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileFault {
    /// The system's own error.
    #[error("{}", crate::source::error::describe(.0))]
    Io(#[source] Arc<std::io::Error>),
    /// The temporary file that frames are inflated to cannot be written.
    #[error("the temporary file in {} cannot be written: {}", .folder.display(), match .error.kind() {
        std::io::ErrorKind::NotFound => "there is no such folder".to_owned(),
        _ => crate::error::system_words(.error),
    })]
    Temporary {
        /// The system's folder for temporary files.
        folder: std::path::PathBuf,
        /// The system's own error.
        error: Arc<std::io::Error>,
    },
    /// No DICOM in it.
    #[error("no DICOM file")]
    NotDicom,
    /// An entry of a zip archive that cannot be unpacked.
    #[error("cannot be unpacked from the zip archive: {0}")]
    Zip(String),
    /// The file ends before its header does.
    #[error("the file ends at byte {at}, inside its header")]
    HeaderEnds {
        /// Bytes there are.
        at: u64,
    },
    /// An element longer than what is left.
    #[error("element {tag} claims {length} bytes where {left} are left")]
    LengthBeyond {
        /// Group and element.
        tag: Tag,
        /// As claimed.
        length: u64,
        /// As there are.
        left: u64,
    },
    /// Deflated bytes that do not inflate, or fail their checksum.
    #[error("the compressed bytes do not inflate: {0}")]
    Inflate(String),
    /// Sequences within sequences without end.
    #[error("sequences are nested deeper than {limit} levels")]
    TooDeep {
        /// Levels that are followed.
        limit: usize,
    },
    /// An element whose bytes are no element.
    #[error("element {tag}: {what}")]
    BadElement {
        /// Group and element.
        tag: Tag,
        /// What is wrong.
        what: &'static str,
    },
    /// More header than is read.
    #[error("the header needs more than {limit} bytes")]
    HeaderTooLarge {
        /// Bytes that are read.
        limit: u64,
    },
    /// An attribute that an image must have.
    #[error("{attribute} is absent")]
    Missing {
        /// Its name.
        attribute: &'static str,
    },
    /// An attribute with a value that cannot be.
    #[error("{attribute} is {found}, expected {wanted}")]
    BadValue {
        /// Its name.
        attribute: &'static str,
        /// The value, shortened.
        found: String,
        /// What would do.
        wanted: &'static str,
    },
    /// Frames and their functional groups that cannot be brought together.
    #[error("NumberOfFrames is {frames}, but PerFrameFunctionalGroupsSequence has {items} item{}, expected one a frame", if *.items == 1 { "" } else { "s" })]
    FrameItems {
        /// `NumberOfFrames`.
        frames: u64,
        /// Items found.
        items: usize,
    },
    /// Samples of a kind that is not read.
    #[error("{0} is not read")]
    Unsupported(String),
    /// A transfer syntax that is not decoded.
    #[error("transfer syntax {uid} ({name}) is not decoded")]
    Syntax {
        /// TransferSyntaxUID.
        uid: String,
        /// Its name.
        name: String,
    },
    /// Fewer samples than rows, columns and frames need.
    #[error("the pixel data end after {found} of {wanted} bytes")]
    PixelsEnd {
        /// Bytes there are.
        found: u64,
        /// Bytes needed.
        wanted: u64,
    },
    /// More frames than can be listed.
    #[error("NumberOfFrames: {frames} frames, whose list needs more than {MAX_FRAMES_BYTES} bytes")]
    TooManyFrames {
        /// Frames announced.
        frames: u64,
    },
    /// Compressed pixels beyond what any image of their size needs.
    #[error(
        "the compressed pixels need more than {limit} bytes, too many for images of their size"
    )]
    PixelsTooLong {
        /// Bytes that are read.
        limit: u64,
    },
    /// A frame that is not among the fragments.
    #[error("frame {frame} is not in the pixel data ({fragments} fragments for {frames} frames)")]
    NoFrame {
        /// Counted from 1.
        frame: u64,
        /// Fragments found.
        fragments: u64,
        /// Frames announced.
        frames: u64,
    },
    /// Compressed pixels that do not decode.
    #[error("the {syntax} pixels do not decode: {detail}")]
    Codec {
        /// The transfer syntax, by name.
        syntax: String,
        /// The decoder's own words, one line.
        detail: String,
    },
    /// JPEG-LS or lossless JPEG pixels that do not decode.
    #[error("the {syntax} pixels do not decode: {error}")]
    Codestream {
        /// The transfer syntax, by name.
        syntax: String,
        /// What is wrong with the frame.
        error: super::codestream::CodestreamError,
    },
    /// A plane beyond the limits.
    #[error(transparent)]
    Dims(#[from] crate::geom::DimsError),
}

/// Group and element of a DICOM tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Tag(pub u16, pub u16);

impl std::fmt::Display for Tag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "({:04X},{:04X})", self.0, self.1)
    }
}

impl FileFault {
    /// The system's error with a temporary file, without the name that `tempfile` adds to it.
    pub(super) fn temporary(error: std::io::Error) -> Self {
        let error = if error.get_ref().is_some() { error.kind().into() } else { error };
        Self::Temporary { folder: tempfile::env::temp_dir(), error: Arc::new(error) }
    }

    /// The system's error, or a stream that does not inflate.
    pub(super) fn io(error: std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput};
        if matches!(error.kind(), InvalidData | InvalidInput) {
            return Self::Inflate(super::blob::one_line(&error));
        }
        Self::Io(Arc::new(error))
    }
}

impl Failure for FileFault {
    fn kind(&self) -> Kind {
        match self {
            Self::Io(e) if e.kind() == std::io::ErrorKind::NotFound => Kind::NotFound,
            Self::Io(_) => Kind::Unreadable,
            Self::Temporary { .. } => Kind::Unwritable,
            Self::NotDicom => Kind::UnknownFormat,
            Self::Zip(_) | Self::Inflate(_) => Kind::CorruptCompression,
            Self::HeaderEnds { .. } | Self::LengthBeyond { .. } | Self::PixelsEnd { .. } => {
                Kind::TruncatedData
            }
            Self::TooDeep { .. }
            | Self::BadElement { .. }
            | Self::Missing { .. }
            | Self::FrameItems { .. }
            | Self::BadValue { .. } => Kind::BadHeader,
            Self::Unsupported(_) => Kind::UnsupportedType,
            Self::Syntax { .. } => Kind::UnsupportedSyntax,
            Self::NoFrame { .. } | Self::Codec { .. } => Kind::CorruptPixels,
            Self::Codestream { error, .. } => error.kind(),
            Self::HeaderTooLarge { .. }
            | Self::TooManyFrames { .. }
            | Self::PixelsTooLong { .. }
            | Self::Dims(crate::geom::DimsError::PlaneTooLarge(..)) => Kind::TooLarge,
            Self::Dims(_) => Kind::BadDims,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            _ if self.kind() == Kind::TruncatedData => {
                Some("the file was cut short; copy or export it again".to_owned())
            }
            _ if self.kind() == Kind::UnsupportedSyntax => Some(
                "export the series uncompressed, or convert it (dcmdjpeg, gdcmconv --raw)"
                    .to_owned(),
            ),
            Self::Io(e) => crate::error::system_hint(e).map(str::to_owned),
            Self::Temporary { .. } => Some("TMPDIR names another folder for it".to_owned()),
            Self::Codestream { .. } if self.kind() == Kind::TooLarge => None,
            Self::Codestream { .. } | Self::Codec { .. } | Self::NoFrame { .. } => {
                Some("the file is damaged; export it again".to_owned())
            }
            _ => None,
        }
    }
}

/// What stands between DICOM files and a volume.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DicomError {
    /// One file is to blame. `name` is relative to the input.
    #[error("{}{fault}{}", at(.name), others(*.more))]
    File {
        /// The file; empty where it is the input itself.
        name: String,
        /// What is wrong with it.
        fault: FileFault,
        /// How many other files have a fault too.
        more: usize,
    },
    /// Nothing DICOM in the folder or archive.
    #[error("no DICOM image among {files} files")]
    NoImages {
        /// Files looked at.
        files: usize,
    },
    /// Images, but none that could be a slice of a volume.
    #[error("no series that could be a volume, only {found}")]
    NoSeries {
        /// What there is instead.
        found: String,
    },
    /// No such series.
    #[error("no series {asked}; there are {of}")]
    NoSuchSeries {
        /// The number or UID asked for.
        asked: String,
        /// How many volumes there are.
        of: usize,
    },
    /// One slice gives no volume.
    #[error("{} no volume: at least two slices are needed{}", few(*.images, .name), self::left_out(.left_out))]
    TooFew {
        /// How many images there are, all at one position.
        images: usize,
        /// The first file.
        name: String,
        /// Other images of the series, with what keeps them apart.
        left_out: String,
    },
    /// Images that do not say where they lie.
    #[error("the images do not say where they lie: {what}{}", in_brackets(.names))]
    NoGeometry {
        /// What is absent or wrong.
        what: String,
        /// The first files.
        names: String,
    },
    /// A Siemens mosaic.
    #[error("a Siemens mosaic: each picture holds a whole volume as tiles, which is not unpacked")]
    Mosaic,
    /// A gap that says that slices are missing.
    #[error("{count} slice{} missing: {gaps}, the others are {step} mm apart{}", if *.count == 1 { " is" } else { "s are" }, left_out(.faults))]
    MissingSlices {
        /// How many.
        count: usize,
        /// Where.
        gaps: String,
        /// The distance between the other slices along the normal, in mm.
        step: String,
        /// Files that could not be used and may be the missing ones.
        faults: String,
    },
    /// Different images at one position.
    #[error("{count} position{} more than one image: {names}", if *.count == 1 { " holds" } else { "s hold" })]
    Conflict {
        /// Positions concerned.
        count: usize,
        /// The first ones, with file names.
        names: String,
    },
    /// The run was asked to stop.
    #[error("interrupted")]
    Interrupted,
}

fn few(images: usize, name: &str) -> String {
    if images == 1 {
        format!("a single image{} is", in_brackets(name))
    } else {
        format!("all {images} images lie at one position{}, which is", in_brackets(name))
    }
}

fn at(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!("{name}: ") }
}

fn left_out(faults: &str) -> String {
    if faults.is_empty() { String::new() } else { format!("; left out: {faults}") }
}

fn in_brackets(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" ({name})") }
}

/// How many files more.
pub(super) fn others(more: usize) -> String {
    match more {
        0 => String::new(),
        1 => " (and 1 more file)".to_owned(),
        n => format!(" (and {n} more files)"),
    }
}

impl Failure for DicomError {
    fn kind(&self) -> Kind {
        match self {
            Self::File { fault, .. } => fault.kind(),
            Self::NoImages { .. } | Self::NoSeries { .. } | Self::NoSuchSeries { .. } => {
                Kind::NoSeries
            }
            Self::TooFew { .. } | Self::NoGeometry { .. } | Self::Mosaic => Kind::UnfitSeries,
            Self::MissingSlices { .. } => Kind::MissingSlices,
            Self::Conflict { .. } => Kind::ConflictingSlices,
            Self::Interrupted => Kind::Interrupted,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::File { fault, .. } => fault.hint(),
            Self::NoImages { .. } => {
                Some("--recursive takes NIfTI files and archives below a folder too".to_owned())
            }
            Self::NoSuchSeries { .. } => {
                Some("mcubes info lists the series with their numbers".to_owned())
            }
            Self::TooFew { left_out, .. } if !left_out.is_empty() => {
                Some("slices of one volume must agree in that; export the series again".to_owned())
            }
            Self::TooFew { .. } => {
                Some("give the folder with all slices of the series as input".to_owned())
            }
            Self::MissingSlices { .. } => {
                Some("copy the missing images, or --gaps span meshes across the gap".to_owned())
            }
            Self::Conflict { .. } => {
                Some("keep one of each in the folder, or give the series its own folder".to_owned())
            }
            Self::Mosaic => Some(
                "convert the series to NIfTI with dcm2niix, which unpacks it, and mesh that"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}
