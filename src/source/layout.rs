//! Where the samples of one volume stand among the bytes of a file, and how they are stored.
//!
//! Arithmetic on sizes is checked here, once; the readers of planes rely on it. Reads nothing.

use super::raw::{RawError, SizeMismatch};
use super::{AnyPlanes, Planes, SourceError};
use crate::geom::{Dims, DimsError};
use crate::volume::{Note, Sample, StoredType};

/// The samples of one volume among the bytes of a file (after decompression).
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) dims: Dims,
    pub(super) stored: StoredType,
    pub(super) big_endian: bool,
    /// The first byte of the first volume.
    pub(super) offset: u64,
    /// Which volume, from 0.
    pub(super) volume: u64,
    pub(super) n_volumes: u64,
    /// Whether sizes come from a header or from the user.
    pub(super) headless: bool,
}

impl Layout {
    /// Checks that the number of bytes of all volumes can be counted.
    pub(super) fn checked(self) -> Result<Self, SourceError> {
        let [nx, ny, nz] = self.dims.to_array().map(|n| n as i64);
        // `Dims` has checked that one volume fits an i64.
        let total = self.volume_bytes().checked_mul(self.n_volumes);
        let end = total.and_then(|n| n.checked_add(self.offset));
        if end.is_none_or(|n| i64::try_from(n).is_err()) {
            return Err(DimsError::Overflow(nx, ny, nz).into());
        }
        Ok(self)
    }

    pub(super) fn plane_bytes(&self) -> u64 {
        self.dims.plane_len() as u64 * self.stored.size() as u64
    }

    pub(super) fn volume_bytes(&self) -> u64 {
        self.plane_bytes() * self.dims.nz() as u64
    }

    /// Bytes of samples of all volumes.
    pub(super) fn total_bytes(&self) -> u64 {
        self.volume_bytes() * self.n_volumes
    }

    /// The first byte of plane `k` of the volume.
    pub(super) fn plane_start(&self, k: usize) -> u64 {
        self.offset + self.volume * self.volume_bytes() + k as u64 * self.plane_bytes()
    }

    /// Bytes of samples in the volumes after this one.
    pub(super) fn bytes_after(&self) -> u64 {
        self.volume_bytes() * (self.n_volumes - self.volume - 1)
    }

    /// The error for data that end at byte `end` of the file.
    pub(super) fn ends_early(&self, end: u64) -> SourceError {
        let bytes = end.saturating_sub(self.offset).min(self.total_bytes());
        if self.headless {
            return RawError::Size(SizeMismatch::new(end, self)).into();
        }
        SourceError::Truncated {
            planes: bytes / self.plane_bytes(),
            of_planes: self.dims.nz() as u64 * self.n_volumes,
            bytes,
            of_bytes: self.total_bytes(),
        }
    }

    /// What `surplus` bytes after the last sample mean: for a header's file a note, for a raw file
    /// that the user's numbers do not fit.
    pub(super) fn goes_on(&self, surplus: u64) -> Result<Vec<Note>, SourceError> {
        match surplus {
            0 => Ok(Vec::new()),
            _ if self.headless => {
                let found = self.offset.saturating_add(self.total_bytes()).saturating_add(surplus);
                Err(RawError::Size(SizeMismatch::new(found, self)).into())
            }
            bytes => Ok(vec![Note::TrailingBytes { bytes }]),
        }
    }

    /// Checks the size of a whole file, known beforehand.
    pub(super) fn check_size(&self, file_bytes: u64) -> Result<Vec<Note>, SourceError> {
        match file_bytes.checked_sub(self.offset + self.total_bytes()) {
            None => Err(self.ends_early(file_bytes)),
            Some(surplus) => self.goes_on(surplus),
        }
    }

    /// Turns the bytes just read into samples, in place: the file's byte order into this
    /// machine's, 64-bit integers into `f64`.
    pub(super) fn to_native<T: Sample>(&self, plane: &mut [T]) {
        let swap = self.big_endian != cfg!(target_endian = "big");
        let native = |v: u64| if swap { v.swap_bytes() } else { v };
        match self.stored {
            StoredType::U64 => each::<T, u64>(plane, |v| (native(v) as f64).to_bits()),
            StoredType::I64 => each::<T, u64>(plane, |v| (native(v) as i64 as f64).to_bits()),
            _ if !swap => {}
            _ => match size_of::<T>() {
                2 => each::<T, u16>(plane, u16::swap_bytes),
                4 => each::<T, u32>(plane, u32::swap_bytes),
                8 => each::<T, u64>(plane, u64::swap_bytes),
                _ => {}
            },
        }
    }
}

/// Applies `change` to the samples' bits. `T` and `B` are of one size, so the cast cannot fail.
fn each<T: Sample, B: bytemuck::Pod>(plane: &mut [T], change: impl Fn(B) -> B) {
    debug_assert_eq!(size_of::<T>(), size_of::<B>());
    if let Ok(bits) = bytemuck::try_cast_slice_mut::<T, B>(plane) {
        for v in bits {
            *v = change(*v);
        }
    }
}

/// Something that can hand out planes of any sample type, told which by its layout.
pub(super) trait IntoPlanes: Sized {
    fn planes<T: Sample>(self) -> Planes<'static, T>;

    fn any(self, stored: StoredType) -> AnyPlanes<'static> {
        match stored {
            StoredType::U8 => AnyPlanes::U8(self.planes()),
            StoredType::I8 => AnyPlanes::I8(self.planes()),
            StoredType::U16 => AnyPlanes::U16(self.planes()),
            StoredType::I16 => AnyPlanes::I16(self.planes()),
            StoredType::U32 => AnyPlanes::U32(self.planes()),
            StoredType::I32 => AnyPlanes::I32(self.planes()),
            StoredType::F32 => AnyPlanes::F32(self.planes()),
            StoredType::U64 | StoredType::I64 | StoredType::F64 => AnyPlanes::F64(self.planes()),
        }
    }
}
