//! What can go wrong while writing.

use std::io;
use std::path::PathBuf;

use crate::error::{Failure, Kind, system_hint, system_words};

/// A writer's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SinkError {
    /// The system's own error while writing.
    #[error("cannot be written: {}", system_words(.0))]
    Io(#[source] io::Error),
    /// The temporary file that the bytes wait in cannot be written.
    #[error("the temporary file in {} cannot be written: {}", .folder.display(), match .error.kind() {
        io::ErrorKind::NotFound => "there is no such folder".to_owned(),
        _ => system_words(.error),
    })]
    Temporary {
        /// The system's folder for temporary files.
        folder: PathBuf,
        /// The system's own error.
        error: io::Error,
    },
    /// The folder that the file should stand in does not exist.
    #[error("cannot be written: the folder {} does not exist", .0.display())]
    NoFolder(PathBuf),
    /// The path given for the file is a folder.
    #[error("cannot be written: it is a folder, not a file")]
    IsFolder,
    /// More than the format can count.
    #[error("the mesh has {found} {what}, the format can count {limit}")]
    TooMany {
        /// `triangles` or `vertices`.
        what: &'static str,
        /// How many there are.
        found: u64,
        /// The most there can be.
        limit: u64,
    },
    /// The bytes written do not match the totals given: a mistake of the program itself.
    #[error("internal error: {0}")]
    Internal(&'static str),
}

impl Failure for SinkError {
    fn kind(&self) -> Kind {
        match self {
            Self::Io(_) | Self::Temporary { .. } | Self::NoFolder(_) | Self::IsFolder => {
                Kind::Unwritable
            }
            Self::TooMany { .. } => Kind::TooManyTriangles,
            Self::Internal(_) => Kind::Internal,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Io(e) => match e.kind() {
                io::ErrorKind::StorageFull => "the disk is full; make room or write elsewhere",
                io::ErrorKind::QuotaExceeded => {
                    "the quota is used up; make room or write elsewhere"
                }
                io::ErrorKind::PermissionDenied => "choose a folder that you may write to",
                _ => return system_hint(e).map(str::to_owned),
            },
            Self::Temporary { .. } => "TMPDIR names another folder for it",
            Self::NoFolder(_) => "make the folder first",
            Self::IsFolder => "add a file name to the path",
            Self::TooMany { .. } => "--crop or --downsample make the mesh smaller",
            Self::Internal(_) => return None,
        };
        Some(hint.to_owned())
    }
}
