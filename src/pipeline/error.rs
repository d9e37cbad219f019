//! What can stop a run.

use crate::error::{Failure, Kind};
use crate::geom::{PlaceError, Space};
use crate::sink::SinkError;
use crate::source::{SourceError, grouped};

/// A run's failure, without the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The source could not give its planes.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The sink could not take a patch.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The volume cannot be placed.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// No triangle: nothing in the volume reaches the iso value.
    #[error("there is no surface at the iso value {iso}{}", described(*.range, *.open))]
    IsoNotReached {
        /// The level asked for.
        iso: f64,
        /// The least and the greatest value, where they were looked at.
        range: Option<(f64, f64)>,
        /// Whether the cap was left out.
        open: bool,
    },
    /// A list of values was given, and no sample has one of them.
    #[error("no sample has one of the values asked for")]
    NoLabel,
    /// No iso value was given, and the volume does not say one.
    #[error("the volume is not of 0 and one value above it: an iso value is needed")]
    NoIso,
    /// All values are the same, so no threshold parts them.
    #[error("all values are the same: no iso value parts them")]
    OneValue,
    /// More memory than the run may take.
    #[error("about {} needed, the limit is {}", mebibytes(*.needed), exactly(*.limit))]
    TooLarge {
        /// Bytes that the run is thought to take.
        needed: u64,
        /// Bytes that it may take.
        limit: u64,
    },
    /// The system did not give memory for the mesh.
    #[error("{} of memory for the mesh are not to be had", mebibytes(*.bytes))]
    Memory {
        /// How many were asked for.
        bytes: u64,
    },
    /// More than a mesh file can count.
    #[error("the mesh has more than {limit} {what}, which is all that mesh files can count")]
    TooMany {
        /// `triangles` or `vertices`.
        what: &'static str,
        /// The most there can be.
        limit: u64,
    },
    /// A grid or a place that is not the volume's.
    #[error("the volume is of {} samples, its grid of {}", by(*.found), by(*.expected))]
    Grid {
        /// The volume's dimensions.
        found: [usize; 3],
        /// The grid's.
        expected: [usize; 3],
    },
    /// A sink that would name another space than the coordinates are in.
    #[error("the output is to say that it is in {} space, the volume is placed in {}", .named.as_str(), .placed.as_str())]
    Space {
        /// What the sink would write.
        named: Space,
        /// Where the coordinates are.
        placed: Space,
    },
    /// An iso value that no sample can be held against.
    #[error("the iso value is {0}: it has to be a finite number")]
    Iso(f64),
    /// The run was asked to stop.
    #[error("interrupted")]
    Interrupted,
    /// A mistake of the program itself.
    #[error("internal error: {0}")]
    Internal(&'static str),
}

fn by([nx, ny, nz]: [usize; 3]) -> String {
    format!("{nx} x {ny} x {nz}")
}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

/// A limit as it was asked for, which need not be whole mebibytes.
fn exactly(bytes: u64) -> String {
    match bytes {
        1 => "1 byte".to_owned(),
        _ if bytes.is_multiple_of(1 << 20) => mebibytes(bytes),
        _ => format!("{} bytes", grouped(bytes)),
    }
}

/// The part of a message that tells the range.
fn described(range: Option<(f64, f64)>, open: bool) -> String {
    match range {
        Some((low, high)) => {
            let open = if open { ", without the cap (--open)" } else { "" };
            format!(": the values are {low} to {high}{open}")
        }
        None => String::new(),
    }
}

impl Failure for RunError {
    fn kind(&self) -> Kind {
        match self {
            Self::Source(e) => e.kind(),
            Self::Sink(e) => e.kind(),
            Self::Place(_) => Kind::OutOfRangeSpace,
            Self::IsoNotReached { .. }
            | Self::Iso(_)
            | Self::NoLabel
            | Self::NoIso
            | Self::OneValue => Kind::IsoNotReached,
            Self::TooLarge { .. } | Self::Memory { .. } => Kind::TooLarge,
            Self::TooMany { .. } => Kind::TooManyTriangles,
            Self::Grid { .. } => Kind::BadDims,
            Self::Space { .. } => Kind::BadConfig,
            Self::Interrupted => Kind::Interrupted,
            Self::Internal(_) => Kind::Internal,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Source(e) => e.hint(),
            Self::Sink(e) => e.hint(),
            Self::Place(_) => Some("--space voxel writes voxel indices instead".to_owned()),
            Self::TooLarge { .. } => Some(
                "--max-memory raises the limit; fewer --threads need less, and so does --crop"
                    .to_owned(),
            ),
            Self::TooMany { .. } => Some("--crop makes the mesh smaller".to_owned()),
            Self::NoLabel => Some(
                "--mask goes by values as they are stored, before slope and intercept".to_owned(),
            ),
            Self::NoIso => {
                Some("--iso 300 for bone in CT; mcubes info FILE suggests some".to_owned())
            }
            _ => None,
        }
    }
}
