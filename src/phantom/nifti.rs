//! Writes a volume as NIfTI, plane by plane: version 1, or 2 where version 1 cannot count the
//! samples. Little-endian, sform only, millimetres.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::PhantomError;
use super::ahead::in_order;
use crate::cancel::Cancel;
use crate::sink::Target;
use crate::source::{Planes, SourceError, Volume};
use crate::volume::{Meta, Sample, StoredType};
use crate::with_planes;

/// The compression level: noise does not shrink at any, smooth fields do at this one.
const LEVEL: u32 = 4;

/// NIfTI's code for millimetres.
const MILLIMETRES: u8 = 2;

/// NIfTI's code for scanner coordinates.
const SCANNER: i16 = 1;

/// Writes a volume whose samples are of the type that its facts say; 64-bit integers come as `f64`.
pub(super) fn write(
    path: Option<&Path>,
    volume: Volume<'_>,
    threads: usize,
    cancel: &Cancel,
) -> Result<(), PhantomError> {
    let Volume { meta, planes } = volume;
    let zipped = path.and_then(Path::extension).is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let target = path.map_or_else(Target::stdout, Target::create)?;
    let fault = |e| target.fault(e);
    let file = target.file().try_clone().map_err(fault)?;
    let mut out = BufWriter::with_capacity(256 << 10, file);
    let run = |out: &mut dyn Write| {
        out.write_all(&header(&meta)).map_err(fault)?;
        with_planes!(planes, planes => copy(&meta, planes, out, &target, threads, cancel))
    };
    if zipped {
        let mut encoder = GzEncoder::new(&mut out, Compression::new(LEVEL));
        run(&mut encoder)?;
        encoder.finish().map_err(fault)?;
    } else {
        run(&mut out)?;
    }
    out.flush().map_err(fault)?;
    drop(out);
    target.commit()?;
    Ok(())
}

fn copy<T: Sample>(
    meta: &Meta,
    planes: Planes<'_, T>,
    out: &mut dyn Write,
    target: &Target,
    threads: usize,
    cancel: &Cancel,
) -> Result<(), PhantomError> {
    // A phantom's planes are made where they are wanted, so there is no other way to have them.
    let Planes::Positioned(planes) = planes else {
        return Err(PhantomError::Internal("the planes of a phantom cannot be had in any order"));
    };
    in_order(&*planes, meta.grid.dims, threads, cancel, |plane| {
        let samples = plane.as_slice().ok_or(SourceError::PlaneBuffer)?;
        Ok(put(meta.stored, samples, out).map_err(|e| target.fault(e))?)
    })
}

/// Samples as little-endian bytes; `f64` of a volume of 64-bit integers as these.
fn put<T: Sample>(stored: StoredType, samples: &[T], out: &mut dyn Write) -> io::Result<()> {
    if let (StoredType::I64 | StoredType::U64, StoredType::F64) = (stored, T::TYPE) {
        let bytes: Vec<u8> = samples
            .iter()
            .flat_map(|x| match stored {
                StoredType::I64 => (x.to_f64() as i64).to_le_bytes(),
                _ => (x.to_f64() as u64).to_le_bytes(),
            })
            .collect();
        return out.write_all(&bytes);
    }
    let bytes: &[u8] = bytemuck::cast_slice(samples);
    if cfg!(target_endian = "little") {
        return out.write_all(bytes);
    }
    let swapped: Vec<u8> =
        bytes.chunks_exact(size_of::<T>()).flat_map(|x| x.iter().rev().copied()).collect();
    out.write_all(&swapped)
}

/// NIfTI's datatype code of what is written.
fn datatype(stored: StoredType) -> i16 {
    match stored {
        StoredType::U8 => 2,
        StoredType::I16 => 4,
        StoredType::I32 => 8,
        StoredType::F32 => 16,
        StoredType::F64 => 64,
        StoredType::I8 => 256,
        StoredType::U16 => 512,
        StoredType::U32 => 768,
        StoredType::I64 => 1024,
        StoredType::U64 => 1280,
    }
}

/// A header in the making: fields one after another, little-endian.
struct Bytes(Vec<u8>);

impl Bytes {
    fn put<const N: usize>(&mut self, field: [u8; N]) {
        self.0.extend_from_slice(&field);
    }

    fn zeros(&mut self, n: usize) {
        self.0.resize(self.0.len() + n, 0);
    }

    /// A field of text, cut or filled up with zeros.
    fn text(&mut self, text: &str, n: usize) {
        let end = self.0.len() + n;
        // The last byte stays 0, as C wants it.
        self.0.extend(text.bytes().filter(u8::is_ascii).take(n - 1));
        self.0.resize(end, 0);
    }
}

fn header(meta: &Meta) -> Vec<u8> {
    let dims = meta.grid.dims.to_array();
    let small = dims.map(|n| i16::try_from(n).ok());
    match small {
        [Some(nx), Some(ny), Some(nz)] => version_1(meta, [nx, ny, nz]),
        _ => version_2(meta, dims.map(|n| n as i64)),
    }
}

/// The 348 bytes of `nifti1.h`, and four that say that no extension follows.
fn version_1(meta: &Meta, dims: [i16; 3]) -> Vec<u8> {
    let mut h = Bytes(Vec::with_capacity(352));
    h.put(348_i32.to_le_bytes());
    h.zeros(36);
    for n in [3, dims[0], dims[1], dims[2], 1, 1, 1, 1] {
        h.put(n.to_le_bytes());
    }
    h.zeros(14);
    h.put(datatype(meta.stored).to_le_bytes());
    h.put((8 * meta.stored.size() as i16).to_le_bytes());
    h.zeros(2);
    let [si, sj, sk] = meta.grid.affine.spacing();
    for s in [1.0, si, sj, sk, 0.0, 0.0, 0.0, 0.0] {
        h.put((s as f32).to_le_bytes());
    }
    for v in [352.0, meta.rescale.slope(), meta.rescale.inter()] {
        h.put((v as f32).to_le_bytes());
    }
    h.zeros(3);
    h.put([MILLIMETRES]);
    h.zeros(24);
    h.text(meta.description.as_deref().unwrap_or_default(), 80);
    h.zeros(24);
    h.put(0_i16.to_le_bytes());
    h.put(SCANNER.to_le_bytes());
    h.zeros(24);
    for v in meta.grid.affine.rows().iter().flatten() {
        h.put((*v as f32).to_le_bytes());
    }
    h.zeros(16);
    h.put(*b"n+1\0");
    h.zeros(4);
    h.0
}

/// The 540 bytes of `nifti2.h`, and four that say that no extension follows.
fn version_2(meta: &Meta, dims: [i64; 3]) -> Vec<u8> {
    let mut h = Bytes(Vec::with_capacity(544));
    h.put(540_i32.to_le_bytes());
    h.put(*b"n+2\0\r\n\x1a\n");
    h.put(datatype(meta.stored).to_le_bytes());
    h.put((8 * meta.stored.size() as i16).to_le_bytes());
    for n in [3, dims[0], dims[1], dims[2], 1, 1, 1, 1] {
        h.put(n.to_le_bytes());
    }
    h.zeros(24);
    let [si, sj, sk] = meta.grid.affine.spacing();
    for s in [1.0, si, sj, sk, 0.0, 0.0, 0.0, 0.0] {
        h.put(s.to_le_bytes());
    }
    h.put(544_i64.to_le_bytes());
    h.put(meta.rescale.slope().to_le_bytes());
    h.put(meta.rescale.inter().to_le_bytes());
    h.zeros(48);
    h.text(meta.description.as_deref().unwrap_or_default(), 80);
    h.zeros(24);
    h.put(0_i32.to_le_bytes());
    h.put(i32::from(SCANNER).to_le_bytes());
    h.zeros(48);
    for v in meta.grid.affine.rows().iter().flatten() {
        h.put(v.to_le_bytes());
    }
    h.zeros(4);
    h.put(i32::from(MILLIMETRES).to_le_bytes());
    h.zeros(36);
    h.zeros(4);
    h.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phantom::{Phantom, Shape};

    #[test]
    fn headers_have_the_length_that_they_say() {
        let meta = Phantom::new(Shape::Torus).volume().unwrap().meta;
        assert_eq!(version_1(&meta, [128; 3]).len(), 352);
        assert_eq!(version_2(&meta, [128; 3]).len(), 544);
    }
}
