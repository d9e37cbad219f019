//! What can be wrong with a phantom, or with writing it.

use crate::error::{Failure, Kind};
use crate::geom::DimsError;
use crate::sink::SinkError;
use crate::source::SourceError;

/// A phantom's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PhantomError {
    /// Dimensions that are no size of a volume.
    #[error(transparent)]
    Dims(#[from] DimsError),
    /// A spacing that is no distance.
    #[error("the spacing is {0} x {1} x {2} mm, each must be above 0 and within single precision")]
    Spacing(f64, f64, f64),
    /// A noise that is no deviation.
    #[error("the noise is {0}, it must be finite and not negative")]
    Noise(f64),
    /// The volume could not give its planes.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The file could not be written.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// A mistake of the program itself.
    #[error("internal error: {0}")]
    Internal(&'static str),
    /// Asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl Failure for PhantomError {
    fn kind(&self) -> Kind {
        match self {
            Self::Dims(DimsError::PlaneTooLarge(..)) => Kind::TooLarge,
            Self::Dims(_) => Kind::BadDims,
            Self::Spacing(..) => Kind::BadAffine,
            Self::Noise(_) => Kind::BadConfig,
            Self::Source(e) => e.kind(),
            Self::Sink(e) => e.kind(),
            Self::Internal(_) => Kind::Internal,
            Self::Interrupted => Kind::Interrupted,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Source(e) => e.hint(),
            Self::Sink(e) => e.hint(),
            _ => None,
        }
    }
}
