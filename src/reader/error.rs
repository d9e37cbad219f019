//! What can be wrong with a mesh file.

use std::io;

use crate::error::{Failure, Kind, system_words};

/// A mesh reader's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The system's own error while reading.
    #[error("{}", match .0.kind() {
        io::ErrorKind::NotFound => "does not exist".to_owned(),
        _ => format!("cannot be read: {}", system_words(.0)),
    })]
    Io(#[from] io::Error),
    /// The path is a folder.
    #[error("is a folder, not a mesh file")]
    IsFolder,
    /// Neither STL nor PLY nor OBJ.
    #[error("is no mesh file: neither STL nor PLY nor OBJ")]
    UnknownFormat,
    /// The file is too short for what its header counts.
    #[error("the header counts {count} {what}, which take {wanted} bytes; there are {found}")]
    TooShort {
        /// `triangles`, or the name of a PLY element.
        what: String,
        /// As the header has it.
        count: u64,
        /// The least number of bytes that the file must then have.
        wanted: u128,
        /// The bytes there are.
        found: u64,
    },
    /// The file ends in the middle.
    #[error("the data end within {within}")]
    EndsWithin {
        /// What is not whole.
        within: String,
    },
    /// A line of text that is not what the format wants there.
    #[error("line {line}: expected {expected}, found '{found}'")]
    Line {
        /// Counted from 1.
        line: u64,
        /// What the format wants.
        expected: &'static str,
        /// The beginning of what stands there.
        found: String,
    },
    /// A header that is not what the format wants.
    #[error("{0}")]
    Header(String),
    /// A face that names a vertex that is not there.
    #[error("face {face} names vertex {id}, there are {n_vertices}")]
    NoSuchVertex {
        /// Counted from 1.
        face: u64,
        /// As the file counts.
        id: i64,
        /// How many there are.
        n_vertices: u64,
    },
    /// A face of fewer than three corners.
    #[error("face {face} has {corners} corners, expected 3 or more")]
    FewCorners {
        /// Counted from 1.
        face: u64,
        /// How many it has.
        corners: u64,
    },
    /// More than can be looked at.
    #[error("there are more than {limit} {what}")]
    TooMany {
        /// `vertices` or `triangles`.
        what: &'static str,
        /// The most there can be.
        limit: u64,
    },
}

impl Failure for ReadError {
    fn kind(&self) -> Kind {
        match self {
            Self::Io(e) if e.kind() == io::ErrorKind::NotFound => Kind::NotFound,
            Self::Io(_) | Self::IsFolder => Kind::Unreadable,
            Self::UnknownFormat => Kind::UnknownFormat,
            Self::TooShort { .. } | Self::EndsWithin { .. } => Kind::TruncatedData,
            Self::Line { .. }
            | Self::Header(_)
            | Self::NoSuchVertex { .. }
            | Self::FewCorners { .. } => Kind::BadHeader,
            Self::TooMany { .. } => Kind::TooLarge,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::IsFolder => "name the files in it",
            Self::TooShort { .. } | Self::EndsWithin { .. } => {
                "the file was cut short; copy or write it again"
            }
            _ => return None,
        };
        Some(hint.to_owned())
    }
}
