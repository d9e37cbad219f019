//! From a header's fields to the facts about its volumes: dimensions, type, scaling, offset.

use super::NiftiError;
use super::affine::affine;
use super::fields::{Fields, SIZE_1, SIZE_2, VoxOffset};
use crate::geom::{Dims, Grid};
use crate::source::SourceError;
use crate::source::layout::Layout;
use crate::volume::{Meta, Note, Rescale, SourceFormat, StoredType};

/// Where the samples of a single file of NIfTI-1 begin at the earliest.
const FIRST: u64 = 352;

/// What a header says, checked.
#[derive(Debug)]
pub(in crate::source) struct Header {
    /// The facts of the first volume.
    pub(in crate::source) meta: Meta,
    /// Where the first volume's samples stand.
    pub(in crate::source) layout: Layout,
    /// Whether they stand in the same file.
    pub(in crate::source) single: bool,
    /// Bytes of the header itself.
    pub(in crate::source) size: u64,
}

impl Header {
    /// Parses and checks the first bytes of a file.
    pub(in crate::source) fn parse(head: &[u8]) -> Result<Self, SourceError> {
        let fields = Fields::parse(head)?;
        let stored = stored_type(&fields)?;
        let (dims, n_volumes) = dims(&fields, stored)?;
        let (affine, mut notes) = affine(&fields, dims)?;
        let offset = offset(&fields, &mut notes)?;
        let layout = Layout {
            dims,
            stored,
            big_endian: fields.big_endian,
            offset,
            volume: 0,
            n_volumes,
            headless: false,
        }
        .checked()
        .map_err(|_| NiftiError::Offset {
            found: format!("{offset}"),
            expected: "a place in a file".to_owned(),
        })?;
        let mut meta = Meta::plain(SourceFormat::Nifti, Grid::new(dims, affine), stored);
        meta.rescale = rescale(&fields)?;
        meta.n_volumes = usize::try_from(n_volumes)
            .map_err(|_| NiftiError::TooManyVolumes(fields.dim.to_vec()))?;
        meta.notes = notes;
        let size = if fields.version == 1 { SIZE_1 } else { SIZE_2 } as u64;
        Ok(Self { meta, layout, single: fields.single, size })
    }
}

/// The first three dimensions and the product of the others. What stands past dim[0] does not
/// count; a missing second or third dimension is 1.
fn dims(fields: &Fields, stored: StoredType) -> Result<(Dims, u64), SourceError> {
    let n_dims = fields.dim[0];
    let counts = usize::try_from(n_dims).ok().filter(|n| (1..=7).contains(n));
    let counts = counts.and_then(|n| fields.dim.get(1..=n)).ok_or(NiftiError::DimCount(n_dims))?;
    let dim = |d: usize| counts.get(d).copied().unwrap_or(1);
    let dims = Dims::checked(dim(0), dim(1), dim(2), stored.size())?;
    let overflow = || NiftiError::TooManyVolumes(counts.to_vec());
    let mut n_volumes: u64 = 1;
    for (at, &count) in counts.iter().enumerate().skip(3) {
        let count = u64::try_from(count).ok().filter(|&n| n > 0);
        let count = count.ok_or(NiftiError::Dim(at + 1, dim(at)))?;
        n_volumes = n_volumes.checked_mul(count).ok_or_else(overflow)?;
    }
    let samples = dims.n_samples().checked_mul(n_volumes);
    if samples.and_then(|n| n.checked_mul(8)).is_none_or(|n| i64::try_from(n).is_err()) {
        return Err(overflow().into());
    }
    Ok((dims, n_volumes))
}

/// The type and its name, by the standard's code.
fn stored_type(fields: &Fields) -> Result<StoredType, NiftiError> {
    let code = fields.datatype;
    let (stored, name) = match code {
        2 => (StoredType::U8, "uint8"),
        4 => (StoredType::I16, "int16"),
        8 => (StoredType::I32, "int32"),
        16 => (StoredType::F32, "float32"),
        64 => (StoredType::F64, "float64"),
        256 => (StoredType::I8, "int8"),
        512 => (StoredType::U16, "uint16"),
        768 => (StoredType::U32, "uint32"),
        1024 => (StoredType::I64, "int64"),
        1280 => (StoredType::U64, "uint64"),
        other => {
            let name = match other {
                0 => "unknown",
                1 => "1-bit",
                32 => "complex64",
                128 => "RGB24",
                255 => "all",
                1536 => "float128",
                1792 => "complex128",
                2048 => "complex256",
                2304 => "RGBA32",
                _ => "not in the standard",
            };
            return Err(NiftiError::Datatype { code, name });
        }
    };
    let expected = 8 * stored.size();
    if usize::try_from(fields.bitpix) != Ok(expected) {
        return Err(NiftiError::Bitpix { found: fields.bitpix, code, name, expected });
    }
    Ok(stored)
}

/// The first byte of the first sample, in the file that holds the samples.
fn offset(fields: &Fields, notes: &mut Vec<Note>) -> Result<u64, NiftiError> {
    let header = if fields.version == 1 { SIZE_1 } else { SIZE_2 } as u64;
    let least = if fields.single { header } else { 0 };
    let wrong = |found: String| NiftiError::Offset {
        found,
        expected: format!("a whole number of bytes from {least} on"),
    };
    let (value, found) = match fields.vox_offset {
        // Below 2⁵³, so that the conversion is exact.
        VoxOffset::Float(v) => {
            let whole = v >= 0.0 && v.fract() == 0.0 && v < 9e15;
            (whole.then_some(v as u64), v.to_string())
        }
        VoxOffset::Integer(v) => (u64::try_from(v).ok(), v.to_string()),
    };
    match value {
        // Below 352 a single file of NIfTI-1 means 352 (nifti1.h): the four bytes after the header
        // tell of extensions. An offset into the header is a mistake.
        Some(value) if fields.version == 1 && fields.single && (least..FIRST).contains(&value) => {
            notes.push(Note::Other(format!("vox_offset is {value}: taken as {FIRST}")));
            Ok(FIRST)
        }
        Some(value) if value >= least => Ok(value),
        _ => Err(wrong(found)),
    }
}

/// No scaling at all where the slope is 0 or not finite, as nibabel has it.
fn rescale(fields: &Fields) -> Result<Rescale, NiftiError> {
    let (slope, inter) = (fields.scl_slope, fields.scl_inter);
    if slope == 0.0 || !slope.is_finite() {
        return Ok(Rescale::IDENTITY);
    }
    Rescale::new(slope, inter).ok_or(NiftiError::Intercept(inter, slope))
}

#[cfg(test)]
mod tests {
    use super::Header;

    /// A header of NIfTI-1 for 2 x 2 x 2 bytes, in one file.
    fn header(vox_offset: f32, pixdim: f32) -> Vec<u8> {
        let mut bytes = vec![0; 352];
        let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
        put(0, &348_i32.to_le_bytes());
        for (n, dim) in [3_i16, 2, 2, 2, 1, 1, 1, 1].iter().enumerate() {
            put(40 + 2 * n, &dim.to_le_bytes());
        }
        put(70, &2_i16.to_le_bytes());
        put(72, &8_i16.to_le_bytes());
        for (n, size) in [1.0, pixdim, 2.0, 2.0].iter().enumerate() {
            put(76 + 4 * n, &size.to_le_bytes());
        }
        put(108, &vox_offset.to_le_bytes());
        put(252, &1_i16.to_le_bytes());
        put(344, b"n+1\0");
        bytes
    }

    fn notes(header: &Header) -> Vec<String> {
        header.meta.notes.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_single_file_begins_its_samples_at_352_at_the_earliest() {
        for (says, begins) in [(348.0, 352), (349.0, 352), (352.0, 352), (368.0, 368)] {
            let header = Header::parse(&header(says, 2.0)).expect("a header");
            assert_eq!(header.layout.offset, begins, "{says}");
            assert_eq!(notes(&header).is_empty(), says >= 352.0, "{says}");
        }
        assert!(Header::parse(&header(0.0, 2.0)).is_err());
        assert!(Header::parse(&header(100.0, 2.0)).is_err());
    }

    #[test]
    fn a_size_of_zero_that_counts_as_one_is_told() {
        let header = Header::parse(&header(352.0, 0.0)).expect("a header");
        assert_eq!(notes(&header), ["pixdim[1] is 0: taken as 1 mm"]);
    }
}
