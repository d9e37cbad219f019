//! Harmless things that a user should know.

use std::fmt;

/// Something noticed while reading or placing a volume that does not stop the run. Printed once
/// each, kept in the JSON report. Each layer adds its variants here, with values, not sentences.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Several volumes in one file; one was taken without being asked for.
    ChoseVolume {
        /// Counted from 1.
        number: usize,
        /// How many there are.
        of: usize,
    },
    /// No sform or qform: the affine is nibabel's base affine, from pixdim.
    AffineFromPixdim,
    /// Coordinates were brought to millimetres.
    UnitsConverted {
        /// `metres` or `micrometres`.
        from: &'static str,
    },
    /// Bytes after the last sample.
    TrailingBytes {
        /// How many.
        bytes: u64,
    },
    /// Bytes after the last gzip member that are no gzip.
    AfterGzip {
        /// How many.
        bytes: u64,
    },
    /// Coordinates are so large that vertices may be off by this part of a voxel.
    CoarseCoordinates {
        /// ε, as a part of a step.
        epsilon: f64,
    },
    /// Anything else, as one line.
    Other(String),
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ChoseVolume { number, of } => {
                write!(f, "volume {number} of {of} is meshed; --volume N chooses another")
            }
            Self::AffineFromPixdim => f.write_str(
                "no sform or qform: the position is nibabel's from pixdim (x flipped, centred)",
            ),
            Self::UnitsConverted { from } => write!(f, "the header's {from} became millimetres"),
            Self::TrailingBytes { bytes } => {
                write!(f, "{bytes} bytes after the last sample are ignored")
            }
            Self::AfterGzip { bytes } => {
                write!(f, "{bytes} bytes after the end of the gzip stream are ignored")
            }
            Self::CoarseCoordinates { epsilon } => write!(
                f,
                "so far from the origin 32-bit coordinates are coarse: vertices may be off by {epsilon:.3} of a voxel; --space voxel avoids it"
            ),
            Self::Other(line) => f.write_str(line),
        }
    }
}
