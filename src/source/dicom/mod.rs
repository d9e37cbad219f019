//! DICOM: any folder that a scanner or an archive exports becomes a study of volumes.
//!
//! [`scan`] reads headers only, through a guard that believes no length; images are grouped into
//! [`Candidate`] volumes and put in geometric order; [`Study::open`] gives planes that are decoded
//! when they are asked for. Nothing that tells who the patient is is read into memory, save the one
//! field that a caller asks for by [`Study::patient`] to name a file with.

mod bits;
mod blob;
mod candidate;
mod codec;
mod codestream;
mod decode;
mod doubles;
mod element;
mod error;
mod every;
mod fragments;
mod groups;
mod guard;
mod header;
mod image_type;
mod instance;
pub mod jpegls;
mod layout;
pub mod ljpeg;
mod lone;
mod neighbours;
mod order;
mod pixels;
mod planes;
mod rle;
mod scan;
mod segments;
mod series;
mod set_aside;
mod shifted;
mod split;
mod start;
mod study;
mod syntax;
mod tags;
mod tree;
mod unpack;
mod walk;

pub use candidate::Candidate;
pub use codestream::{CodestreamError, DecodedFrame};
pub use error::{DicomError, FileFault, Tag};
pub use every::PatientField;
pub use scan::{ScanOptions, scan};
pub use segments::SegmentError;
pub use set_aside::{SetAside, What};
pub use study::{OpenOptions, Selector, Study};
pub use tree::{Tree, scan_tree};

/// Whether the first bytes of a file are those of a zip archive, be it an empty one.
pub(super) fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06")
}

/// How many bytes of a file [`is_dicom`] wants to see.
pub const HEAD_BYTES: usize = 132;

/// Whether the first bytes of a file (132, or all there are) are those of a DICOM file.
pub fn is_dicom(head: &[u8]) -> bool {
    start::looks_like_dicom(head)
}

/// The names of a series' transfer syntaxes, for people.
pub fn syntax_names(series: &crate::volume::SeriesFacts) -> String {
    candidate::syntax_names(series)
}

/// The same in one or two words each, for tables.
pub fn short_syntax_names(series: &crate::volume::SeriesFacts) -> String {
    candidate::short_syntax_names(series)
}
