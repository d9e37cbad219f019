//! Samples without a header: the user says what they are, the size must agree.

use std::path::PathBuf;

use super::file::FilePlanes;
use super::gunzip::Gunzip;
use super::input::{Input, check_gzip_size};
use super::layout::{IntoPlanes, Layout};
use super::stream::StreamPlanes;
use super::{AnyPlanes, SourceError, Volume};
use crate::Error;
use crate::cancel::Cancel;
use crate::error::{Failure, Kind};
use crate::geom::{Affine, Dims, DimsError, Grid};
use crate::source::error::grouped;
use crate::volume::{Meta, SourceFormat, StoredType};

/// Where raw samples come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RawInput {
    /// A file, plain or gzipped.
    Path(PathBuf),
    /// Standard input, plain or gzipped.
    Stdin,
}

/// What the user says of raw samples. They stand plane by plane, row by row, i fastest; the axes
/// i, j, k point right, anterior, superior.
#[derive(Clone, Debug, PartialEq)]
pub struct RawOptions {
    /// Samples along i, j, k.
    pub dims: [i64; 3],
    /// The type of one sample.
    pub stored: StoredType,
    /// Whether the most significant byte comes first.
    pub big_endian: bool,
    /// Distances between samples along i, j, k.
    pub spacing_mm: [f64; 3],
    /// The centre of sample (0, 0, 0).
    pub origin_mm: [f64; 3],
    /// Bytes before the first sample, counted after decompression.
    pub offset_bytes: u64,
}

impl RawOptions {
    /// Little-endian samples with a spacing of 1 mm and the first one at the origin.
    pub fn new(dims: [i64; 3], stored: StoredType) -> Self {
        Self {
            dims,
            stored,
            big_endian: false,
            spacing_mm: [1.0; 3],
            origin_mm: [0.0; 3],
            offset_bytes: 0,
        }
    }
}

/// What is wrong with raw samples, or with what was said of them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RawError {
    /// The number of bytes is another than the dimensions and the type ask for.
    #[error(
        "{} bytes, but {} x {} x {} samples of {}{} are {} bytes",
        grouped(.0.found), .0.dims[0], .0.dims[1], .0.dims[2], .0.stored,
        if .0.offset == 0 { String::new() } else { format!(" from byte {}", grouped(.0.offset)) },
        grouped(.0.expected)
    )]
    Size(SizeMismatch),
    /// A spacing that is no distance.
    #[error("the spacing is {0} x {1} x {2} mm, each must be a positive number")]
    Spacing(f64, f64, f64),
    /// An origin that is no place, or a grid that is not: the numbers are too far apart.
    #[error("the origin is {0}, {1}, {2} mm and the spacing {3} x {4} x {5} mm: no usable grid")]
    Grid(f64, f64, f64, f64, f64, f64),
}

/// Sizes that do not agree.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeMismatch {
    /// Bytes that there are, after decompression, those before the first sample included.
    pub found: u64,
    /// Bytes that there should be, those before the first sample included.
    pub expected: u64,
    /// Samples along i, j, k, as said.
    pub dims: [u64; 3],
    /// The type said.
    pub stored: StoredType,
    /// Bytes before the first sample, as said.
    pub offset: u64,
}

impl SizeMismatch {
    pub(super) fn new(found: u64, layout: &Layout) -> Self {
        Self {
            found,
            expected: layout.offset.saturating_add(layout.total_bytes()),
            dims: layout.dims.to_array().map(|n| n as u64),
            stored: layout.stored,
            offset: layout.offset,
        }
    }

    /// Another type, number of planes or offset that fits the size found, as one line; nothing
    /// where none is obvious.
    pub fn suggestion(&self) -> Option<String> {
        let [nx, ny, nz] = self.dims;
        let plane_len = nx.checked_mul(ny)?;
        let n_samples = plane_len.checked_mul(nz)?;
        let data = self.found.checked_sub(self.offset)?;
        let whole = |by: u64| (data > 0 && by > 0 && data.is_multiple_of(by)).then(|| data / by);
        if let Some(size) = whole(n_samples) {
            let fitting = StoredType::ALL.into_iter().filter(|t| t.size() as u64 == size);
            let names: Vec<&str> = fitting.map(StoredType::as_str).collect();
            if !names.is_empty() {
                return Some(format!("--type {} would fit", names.join(" or ")));
            }
        }
        if let Some(planes) = whole(plane_len.checked_mul(self.stored.size() as u64)?) {
            return Some(format!("--dims {nx}x{ny}x{planes} would fit"));
        }
        let surplus = self.found.checked_sub(self.expected).filter(|&n| n > 0)?;
        let offset = self.offset.checked_add(surplus)?;
        Some(format!("--offset {offset} would fit, if a header of that size comes first"))
    }
}

impl Failure for RawError {
    fn kind(&self) -> Kind {
        match self {
            Self::Size(_) => Kind::SizeMismatch,
            Self::Spacing(..) | Self::Grid(..) => Kind::BadAffine,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Size(mismatch) => mismatch.suggestion(),
            Self::Spacing(..) | Self::Grid(..) => None,
        }
    }
}

/// Opens samples without a header. A plain file is read plane by plane in any order; gzip (told by
/// content) and standard input come in order. `cancel` ends a wait for a pipe, then and while its
/// planes are read.
///
/// # Errors
/// `bad-dims`, `bad-affine`, `too-large`; `size-mismatch` at once for a plain file, else from the
/// planes; what the system says when the file cannot be read.
pub fn open_raw(
    input: RawInput,
    options: &RawOptions,
    cancel: &Cancel,
) -> Result<Volume<'static>, Error> {
    match input {
        RawInput::Path(path) => {
            let open = || from_input(Input::open(&path, cancel)?, options);
            open().map_err(|e| Error::at(&path, e))
        }
        RawInput::Stdin => {
            let open = || from_input(Input::stdin(cancel)?, options);
            open().map_err(|e| Error::at("standard input", e))
        }
    }
}

fn from_input(input: Input, options: &RawOptions) -> Result<Volume<'static>, SourceError> {
    let affine = affine(options)?;
    let size = options.stored.size();
    let [nx, ny, nz] = options.dims;
    let expected = bytes_of(options)?;
    // A plain file may happen to begin just like gzip: the size that fits exactly decides.
    let gzip = Gunzip::recognise_fully(input.head()) && !input.is_just(expected);
    if !gzip && let Some(found) = input.size().filter(|&found| found != expected) {
        let dims = options.dims.map(|n| n as u64);
        let mismatch = SizeMismatch {
            found,
            expected,
            dims,
            stored: options.stored,
            offset: options.offset_bytes,
        };
        return Err(RawError::Size(mismatch).into());
    }
    let dims = Dims::checked(nx, ny, nz, size)?;
    let layout = Layout {
        dims,
        stored: options.stored,
        big_endian: options.big_endian,
        offset: options.offset_bytes,
        volume: 0,
        n_volumes: 1,
        headless: true,
    }
    .checked()?;
    if gzip {
        check_gzip_size(input.size(), layout.total_bytes())?;
    }
    let meta = Meta::plain(SourceFormat::Raw, Grid::new(dims, affine), options.stored);
    let planes = planes(input, gzip, layout)?;
    Ok(Volume { meta, planes })
}

fn planes(input: Input, gzip: bool, layout: Layout) -> Result<AnyPlanes<'static>, SourceError> {
    let stored = layout.stored;
    let input = if gzip {
        input
    } else {
        match input.into_file() {
            Ok((file, _)) => return Ok(FilePlanes::new(file, layout).any(stored)),
            Err(input) => input,
        }
    };
    Ok(StreamPlanes::new(input.into_stream(gzip)?, layout, 0).any(stored))
}

/// Bytes of the whole file, those before the first sample included.
fn bytes_of(options: &RawOptions) -> Result<u64, DimsError> {
    let [nx, ny, nz] = options.dims;
    if nx < 1 || ny < 1 || nz < 1 {
        return Err(DimsError::NotPositive(nx, ny, nz));
    }
    let product =
        options.dims.iter().try_fold(options.stored.size() as i64, |n, d| n.checked_mul(*d));
    let bytes = product.and_then(|n| (n as u64).checked_add(options.offset_bytes));
    bytes.filter(|&n| i64::try_from(n).is_ok()).ok_or(DimsError::Overflow(nx, ny, nz))
}

fn affine(options: &RawOptions) -> Result<Affine, RawError> {
    let [si, sj, sk] = options.spacing_mm;
    let [x, y, z] = options.origin_mm;
    if !options.spacing_mm.iter().all(|s| s.is_finite() && *s > 0.0) {
        return Err(RawError::Spacing(si, sj, sk));
    }
    let affine =
        Affine::from_columns([si, 0.0, 0.0], [0.0, sj, 0.0], [0.0, 0.0, sk], options.origin_mm);
    if affine.is_usable() { Ok(affine) } else { Err(RawError::Grid(x, y, z, si, sj, sk)) }
}
