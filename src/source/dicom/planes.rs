//! The planes of a volume: frames read, decoded and unpacked on the thread that asks.

use std::cell::RefCell;
use std::marker::PhantomData;

use ndarray::ArrayViewMut2;

use super::decode::Image;
use super::error::DicomError;
use super::layout::Layout;
use super::pixels::Slice;
use super::unpack::{self, FromStored};
use crate::source::{AnyPlanes, Planes, PositionedPlanes, SourceError};
use crate::volume::{Inside, Meta, Rescale, Sample, StoredType};

/// Reads a slice's samples into a plane; the bytes are room to read into.
type Fill<T> = fn(&Slice, &mut Vec<u8>, &mut [T]) -> Result<(), DicomError>;

/// The planes of slices in order, in the type that `meta` says; real values in `f64` where types,
/// slopes or padding change from slice to slice (`uniform` is false).
pub(super) fn open(slices: Vec<Slice>, meta: &Meta, uniform: bool) -> AnyPlanes<'static> {
    fn boxed<T: Sample>(slices: Vec<Slice>, fill: Fill<T>) -> Planes<'static, T> {
        Planes::Positioned(Box::new(Frames { slices, fill, samples: PhantomData }))
    }
    if !uniform {
        return AnyPlanes::F64(boxed(slices, real));
    }
    match meta.stored {
        StoredType::U8 => AnyPlanes::U8(boxed(slices, stored)),
        StoredType::I8 => AnyPlanes::I8(boxed(slices, stored)),
        StoredType::U16 => AnyPlanes::U16(boxed(slices, stored)),
        StoredType::I16 => AnyPlanes::I16(boxed(slices, stored)),
        StoredType::U32 => AnyPlanes::U32(boxed(slices, stored)),
        StoredType::I32 => AnyPlanes::I32(boxed(slices, stored)),
        StoredType::F32 => AnyPlanes::F32(boxed(slices, float)),
        StoredType::F64 | StoredType::I64 | StoredType::U64 => {
            AnyPlanes::F64(boxed(slices, double))
        }
    }
}

struct Frames<T> {
    slices: Vec<Slice>,
    fill: Fill<T>,
    samples: PhantomData<fn() -> T>,
}

thread_local! {
    /// The bytes of one frame, used again for the next one that this thread reads.
    static STORED: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

impl<T: Sample> PositionedPlanes<T> for Frames<T> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        let Some(slice) = self.slices.get(k) else {
            return Err(SourceError::Io(std::io::ErrorKind::UnexpectedEof.into()));
        };
        let mut bytes = STORED.take();
        let result = if let Some(plane) = out.as_slice_mut() {
            (self.fill)(slice, &mut bytes, plane)
        } else {
            let mut plane = vec![T::default(); out.len()];
            let result = (self.fill)(slice, &mut bytes, &mut plane);
            out.iter_mut().zip(plane).for_each(|(to, from)| *to = from);
            result
        };
        STORED.replace(bytes);
        result.map_err(|e| SourceError::Dicom(Box::new(e)))
    }

    fn keep_padding(&mut self, inside: Inside) {
        for slice in &mut self.slices {
            slice.inside = Some(inside);
        }
    }
}

/// Reads the frame of a slice; nothing where none was stored, so that the plane is zero.
fn read<'a>(
    slice: &'a Slice,
    bytes: &mut Vec<u8>,
) -> Result<Option<(&'a Layout, Image)>, DicomError> {
    let Some(pixels) = &slice.pixels else { return Ok(None) };
    match pixels.read(slice.frame, bytes) {
        Ok(image) => Ok(Some((&pixels.layout, image))),
        Err(fault) => Err(DicomError::File { name: pixels.name.clone(), fault, more: 0 }),
    }
}

fn stored<T: FromStored>(
    slice: &Slice,
    bytes: &mut Vec<u8>,
    out: &mut [T],
) -> Result<(), DicomError> {
    match read(slice, bytes)? {
        Some((layout, image)) => unpack::integers(layout, &image, slice.padding, bytes, out),
        None => out.fill(T::default()),
    }
    Ok(())
}

fn float(slice: &Slice, bytes: &mut Vec<u8>, out: &mut [f32]) -> Result<(), DicomError> {
    match read(slice, bytes)? {
        Some((layout, image)) => unpack::floats(layout, &image, bytes, out, |v| v as f32),
        None => out.fill(0.0),
    }
    Ok(())
}

fn double(slice: &Slice, bytes: &mut Vec<u8>, out: &mut [f64]) -> Result<(), DicomError> {
    match read(slice, bytes)? {
        Some((layout, image)) => unpack::floats(layout, &image, bytes, out, |v| v),
        None => out.fill(0.0),
    }
    Ok(())
}

/// Real values; padding becomes NaN, which is outside at any level, unless a level is known at
/// which it is outside by its own value.
fn real(slice: &Slice, bytes: &mut Vec<u8>, out: &mut [f64]) -> Result<(), DicomError> {
    let Some((layout, image)) = read(slice, bytes)? else {
        out.fill(0.0);
        return Ok(());
    };
    let rescale = Rescale::new(slice.slope, slice.inter).unwrap_or(Rescale::IDENTITY);
    unpack::real(layout, &image, slice.padding, bytes, out, |v| {
        let real = rescale.real(v);
        let padded = slice.padding.is_some_and(|p| p.holds(v));
        if padded && slice.inside.is_none_or(|inside| inside.holds(real)) { f64::NAN } else { real }
    });
    Ok(())
}
