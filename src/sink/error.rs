//! What can go wrong while writing.

use crate::error::{Failure, Kind};

/// A writer's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SinkError {
    /// The system's own error while writing.
    #[error("cannot be written: {0}")]
    Io(#[source] std::io::Error),
}

impl Failure for SinkError {
    fn kind(&self) -> Kind {
        Kind::Unwritable
    }
}
