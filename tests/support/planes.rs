//! Reading volumes through the library as a list of numbers.

use std::path::Path;

use mcubes::source::{AnyPlanes, Planes, SourceError, Volume};
use mcubes::volume::{Meta, Note, Sample};
use mcubes::with_planes;
use ndarray::Array2;

/// Every sample as handed on, in file order, as `f64`; and the notes of the end.
pub fn samples(volume: Volume<'_>) -> Result<(Vec<f64>, Vec<Note>), SourceError> {
    fn of<T: Sample>(
        meta: &Meta,
        planes: Planes<'_, T>,
    ) -> Result<(Vec<f64>, Vec<Note>), SourceError> {
        let [nx, ny, nz] = meta.grid.dims.to_array();
        let mut out = Vec::new();
        let mut plane = Array2::<T>::default((ny, nx));
        match planes {
            Planes::Ordered(mut ordered) => {
                for _ in 0..nz {
                    ordered.next_plane(plane.view_mut())?;
                    out.extend(plane.iter().map(|v| v.to_f64()));
                }
                return ordered.finish().map(|notes| (out, notes));
            }
            // Backwards, since any order must do.
            Planes::Positioned(positioned) => {
                let mut slabs = Vec::new();
                for k in (0..nz).rev() {
                    positioned.read_plane(k, plane.view_mut())?;
                    slabs.push(plane.iter().map(|v| v.to_f64()).collect::<Vec<_>>());
                }
                out.extend(slabs.into_iter().rev().flatten());
            }
            Planes::Resident(array) => out.extend(array.iter().map(|v| v.to_f64())),
        }
        Ok((out, Vec::new()))
    }
    let meta = volume.meta;
    with_planes!(volume.planes, planes => of(&meta, planes))
}

/// Whether the planes can be had in any order.
pub fn is_positioned(volume: &Volume<'_>) -> bool {
    macro_rules! ask {
        ($($name:ident)*) => {
            match &volume.planes {
                $(AnyPlanes::$name(p) => matches!(p, Planes::Positioned(_)),)*
            }
        };
    }
    ask!(U8 I8 U16 I16 U32 I32 F32 F64)
}

/// The checksum of `expected-nifti.json`: CRC-32 of the values as little-endian `f64`, every NaN
/// made the same.
pub fn checksum(values: impl IntoIterator<Item = f64>) -> String {
    let mut hasher = crc32fast::Hasher::new();
    for v in values {
        let bits = if v.is_nan() { 0x7ff8_0000_0000_0000 } else { v.to_bits() };
        hasher.update(&bits.to_le_bytes());
    }
    format!("{:08x}", hasher.finalize())
}

/// Opens, reads everything, and gives the kind of whatever goes wrong on the way.
pub fn read_all(
    opened: Result<Volume<'static>, mcubes::Error>,
    path: &Path,
) -> Result<(Meta, Vec<f64>, Vec<Note>), mcubes::Error> {
    let volume = opened?;
    let meta = volume.meta.clone();
    let (values, notes) = samples(volume).map_err(|e| mcubes::Error::at(path, e))?;
    Ok((meta, values, notes))
}
