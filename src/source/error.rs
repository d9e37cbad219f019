//! What can be wrong with an input.

use super::WrapError;
use crate::error::{Failure, Kind};
use crate::geom::DimsError;

/// A source's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The system's own error while reading.
    #[error("cannot be read: {0}")]
    Io(#[source] std::io::Error),
    /// Dimensions that are no size of a volume.
    #[error(transparent)]
    Dims(#[from] DimsError),
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

impl Failure for SourceError {
    fn kind(&self) -> Kind {
        match self {
            Self::Io(e) if e.kind() == std::io::ErrorKind::NotFound => Kind::NotFound,
            Self::Io(_) => Kind::Unreadable,
            Self::Dims(DimsError::PlaneTooLarge(..)) => Kind::TooLarge,
            Self::Dims(_) => Kind::BadDims,
            Self::Wrap(e) => e.kind(),
            Self::Other { kind, .. } => *kind,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Other { hint, .. } => hint.clone(),
            Self::Wrap(e) => e.hint(),
            _ => None,
        }
    }
}
