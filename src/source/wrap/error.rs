//! What a step that wraps a source cannot do.

use crate::error::Kind;
use crate::geom::RegridError;
use crate::volume::StoredType;

/// A step's failure, before any sample is read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WrapError {
    /// A box or block that does not fit the volume.
    #[error(transparent)]
    Regrid(#[from] RegridError),
    /// A sigma that is no length.
    #[error("blur {0} mm: sigma must be finite and not negative")]
    Sigma(f64),
    /// A blur over planes that are not evenly spaced.
    #[error("the planes are not evenly spaced, so they cannot be blurred")]
    UnevenBlur,
    /// A blur that must hold too many planes at once.
    #[error("blur: {bytes} bytes needed for {planes} planes, the limit is {limit} bytes")]
    Window {
        /// Planes held at once.
        planes: u64,
        /// Their size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// Labels where only real values are to be had.
    #[error("the rescale changes from slice to slice: no sample has its stored value ({0})")]
    NotStored(StoredType),
    /// A label among numbers that are not told apart.
    #[error(
        "label {0}: {1} samples are read as f64, which does not tell integers from 2⁵³ on apart"
    )]
    CoarseLabel(f64, StoredType),
    /// A formula's affine that is not finite or not invertible.
    #[error("the affine is not finite or cannot be inverted")]
    Affine,
}

impl WrapError {
    /// The stable word.
    pub(in crate::source) fn kind(&self) -> Kind {
        match self {
            Self::Regrid(RegridError::NotInvertible) | Self::Affine => Kind::BadAffine,
            Self::Regrid(_) => Kind::BadDims,
            Self::Sigma(_) | Self::CoarseLabel(..) => Kind::BadConfig,
            Self::UnevenBlur | Self::NotStored(_) => Kind::UnfitSeries,
            Self::Window { .. } => Kind::TooLarge,
        }
    }

    /// What to do.
    pub(in crate::source) fn hint(&self) -> Option<String> {
        match self {
            Self::Regrid(RegridError::Outside { .. }) => {
                Some("ranges count samples from 0, the end not included".to_owned())
            }
            Self::NotStored(_) => {
                Some("--iso goes by real values; --mask by stored ones".to_owned())
            }
            Self::Window { .. } => Some("a smaller sigma, or --crop, needs fewer".to_owned()),
            _ => None,
        }
    }
}
