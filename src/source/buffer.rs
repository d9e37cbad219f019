//! Memory for samples.

use super::SourceError;
use crate::volume::Sample;

/// `len` samples of the type's default; refused, rather than the end of the process, where there is
/// too little memory.
pub(crate) fn buffer<T: Sample>(len: usize) -> Result<Vec<T>, SourceError> {
    let mut buffer = Vec::new();
    let bytes = (len as u64).saturating_mul(size_of::<T>() as u64);
    buffer.try_reserve_exact(len).map_err(|_| SourceError::Memory { bytes })?;
    buffer.resize(len, T::default());
    Ok(buffer)
}
