//! What can be wrong with a NIfTI header.

use std::path::PathBuf;

use crate::error::{Failure, Kind};
use crate::source::error::grouped;

/// A NIfTI header that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NiftiError {
    /// The file ends within its header.
    #[error("the file ends at byte {found}, a NIfTI header has {of}")]
    ShortHeader {
        /// Bytes that there are.
        found: usize,
        /// Bytes of the header.
        of: usize,
    },
    /// `sizeof_hdr` is that of neither version.
    #[error("sizeof_hdr is {0}, NIfTI-1 has 348 and NIfTI-2 has 540")]
    HeaderSize(i32),
    /// `magic` is not that of the header's version.
    #[error("magic is \"{found}\", a NIfTI-{version} header has n+{version} or ni{version}")]
    Magic {
        /// What stands in its place.
        found: String,
        /// 1 or 2, by the header's size.
        version: u8,
    },
    /// A header of the right size without a magic.
    #[error("looks like Analyze 7.5 (no NIfTI magic), which does not say where left and right are")]
    Analyze,
    /// The end of NIfTI-2's magic, there to catch it, was changed.
    #[error("the header was damaged by a transfer in text mode")]
    TextMode,
    /// `dim[0]` is no number of dimensions.
    #[error("dim[0] is {0}, a number of dimensions from 1 to 7 is wanted")]
    DimCount(i64),
    /// A dimension past the third that is no count.
    #[error("dim[{0}] is {1}, it must be at least 1")]
    Dim(usize, i64),
    /// More volumes than can be counted.
    #[error("dim is {0:?}: the number of samples overflows")]
    TooManyVolumes(Vec<i64>),
    /// A datatype that has no order, or that this library does not read.
    #[error("datatype {code} ({name}) is not read; only integers and floats of 8 to 64 bits are")]
    Datatype {
        /// The code in the header.
        code: i16,
        /// The standard's name for it.
        name: &'static str,
    },
    /// `bitpix` and `datatype` disagree.
    #[error("bitpix is {found} but datatype {code} ({name}) needs {expected}")]
    Bitpix {
        /// `bitpix`.
        found: i16,
        /// `datatype`.
        code: i16,
        /// The standard's name for it.
        name: &'static str,
        /// The bits of that type.
        expected: usize,
    },
    /// `vox_offset` is no place for samples.
    #[error("vox_offset is {found}, expected {expected}")]
    Offset {
        /// The value in the header.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// `scl_slope` is valid and `scl_inter` is not a number.
    #[error("scl_inter is {0} beside a scl_slope of {1}, a finite number is wanted")]
    Intercept(f64, f64),
    /// The quaternion is no rotation.
    #[error("quatern_b, c, d are {0}, {1}, {2}: longer than 1, which is no rotation")]
    Quaternion(f64, f64, f64),
    /// The affine holds something that is not finite, or flattens the volume.
    #[error("the {from} gives no usable map to millimetres: {}", matrix(.rows))]
    Affine {
        /// `sform`, `qform` or `pixdim`.
        from: &'static str,
        /// The map it gives.
        rows: [[f64; 4]; 3],
    },
    /// The other file of a pair is missing.
    #[error("the {what} of this pair is missing; looked for {}", .wanted.display())]
    NoPartner {
        /// `header (.hdr)` or `image (.img)`.
        what: &'static str,
        /// The first name that was tried.
        wanted: PathBuf,
    },
    /// The file has fewer bytes than come before the first sample.
    #[error("vox_offset is {}, the file has {} bytes", grouped(*.offset), grouped(*.file))]
    OffsetBeyond {
        /// The first byte of the first sample.
        offset: u64,
        /// Bytes that there are.
        file: u64,
    },
}

impl NiftiError {
    /// The error for a wrong magic, made printable.
    pub(super) fn magic(found: &[u8], version: u8) -> Self {
        let end = found.iter().rposition(|&b| b != 0).map_or(0, |at| at + 1);
        let found = found.get(..end).unwrap_or_default().escape_ascii().to_string();
        Self::Magic { found, version }
    }
}

impl Failure for NiftiError {
    fn kind(&self) -> Kind {
        match self {
            Self::ShortHeader { .. } => Kind::TruncatedData,
            Self::HeaderSize(_)
            | Self::Magic { .. }
            | Self::TextMode
            | Self::Bitpix { .. }
            | Self::Offset { .. }
            | Self::OffsetBeyond { .. }
            | Self::Intercept(..) => Kind::BadHeader,
            Self::Analyze => Kind::UnknownFormat,
            Self::DimCount(_) | Self::Dim(..) | Self::TooManyVolumes(_) => Kind::BadDims,
            Self::Datatype { .. } => Kind::UnsupportedType,
            Self::Quaternion(..) | Self::Affine { .. } => Kind::BadAffine,
            Self::NoPartner { .. } => Kind::NotFound,
        }
    }

    fn hint(&self) -> Option<String> {
        let line = match self {
            Self::ShortHeader { .. } => "the file was cut short; copy it again",
            Self::TextMode => "copy the file again, in binary mode",
            Self::Analyze => "samples without a header are read with --dims, --type and --offset",
            Self::NoPartner { .. } => "put both files, .hdr and .img, into one folder",
            _ => return None,
        };
        Some(line.to_owned())
    }
}

fn matrix(rows: &[[f64; 4]; 3]) -> String {
    let row = |r: &[f64; 4]| format!("{} {} {} {}", r[0], r[1], r[2], r[3]);
    format!("[{}; {}; {}]", row(&rows[0]), row(&rows[1]), row(&rows[2]))
}
