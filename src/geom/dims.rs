//! The size of a volume, checked once so that later products cannot overflow.

use crate::limits::{MAX_PLANE_BYTES, MAX_PLANE_SAMPLES};

/// Samples along i (fastest), j and k. All are at least 1, and the number of bytes of any sample
/// type in the whole volume fits an `i64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dims {
    nx: usize,
    ny: usize,
    nz: usize,
}

/// Why a size is no size of a volume.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DimsError {
    /// One of the numbers is zero or negative.
    #[error("dimensions {0} x {1} x {2}: each must be at least 1")]
    NotPositive(i64, i64, i64),
    /// The number of samples cannot be counted.
    #[error("dimensions {0} x {1} x {2}: the number of samples overflows")]
    Overflow(i64, i64, i64),
    /// One plane alone is beyond the limit.
    #[error(
        "dimensions {0} x {1} x {2}: one plane of {3} bytes, the limit is {MAX_PLANE_SAMPLES} samples of at most {MAX_PLANE_BYTES} bytes"
    )]
    PlaneTooLarge(i64, i64, i64, u64),
}

impl Dims {
    /// Checks three numbers as a file or a user gave them; `sample_bytes` is the size of one
    /// stored sample.
    ///
    /// # Errors
    /// A number below 1, a product that overflows, a plane beyond [`MAX_PLANE_SAMPLES`] or
    /// [`MAX_PLANE_BYTES`].
    pub fn checked(nx: i64, ny: i64, nz: i64, sample_bytes: usize) -> Result<Self, DimsError> {
        if nx < 1 || ny < 1 || nz < 1 {
            return Err(DimsError::NotPositive(nx, ny, nz));
        }
        let overflow = || DimsError::Overflow(nx, ny, nz);
        // A border sample is added on either side later, and samples may be widened to f64.
        let plane = nx
            .checked_add(2)
            .ok_or_else(overflow)?
            .checked_mul(ny.checked_add(2).ok_or_else(overflow)?);
        let plane = plane.ok_or_else(overflow)?;
        let volume = plane.checked_mul(nz.checked_add(2).ok_or_else(overflow)?);
        volume.and_then(|n| n.checked_mul(8)).ok_or_else(overflow)?;
        let plane_samples = nx as u64 * ny as u64;
        let plane_bytes = plane_samples.saturating_mul(sample_bytes as u64);
        if plane_samples > MAX_PLANE_SAMPLES || plane_bytes > MAX_PLANE_BYTES {
            return Err(DimsError::PlaneTooLarge(nx, ny, nz, plane_bytes));
        }
        let size = |n: i64| usize::try_from(n).map_err(|_| overflow());
        Ok(Self { nx: size(nx)?, ny: size(ny)?, nz: size(nz)? })
    }

    /// Samples along i, the fastest axis.
    pub fn nx(self) -> usize {
        self.nx
    }

    /// Samples along j.
    pub fn ny(self) -> usize {
        self.ny
    }

    /// Planes.
    pub fn nz(self) -> usize {
        self.nz
    }

    /// All three, i first.
    pub fn to_array(self) -> [usize; 3] {
        [self.nx, self.ny, self.nz]
    }

    /// Samples in one plane.
    pub fn plane_len(self) -> usize {
        self.nx * self.ny
    }

    /// Samples in the volume.
    pub fn n_samples(self) -> u64 {
        self.plane_len() as u64 * self.nz as u64
    }
}
