//! The planes of a phantom, made as they are read.

use ndarray::ArrayViewMut2;

use super::Phantom;
use super::noise::normal;
use crate::geom::{Affine, Dims};
use crate::source::{AnyPlanes, Planes, PositionedPlanes, SourceError};
use crate::volume::{Rescale, Sample, StoredType};

/// Makes each sample's real value, with its noise.
struct Field {
    dims: Dims,
    affine: Affine,
    rescale: Rescale,
    noise: f64,
    seed: u64,
    /// Stored values are rounded and kept between these.
    whole: Option<(f64, f64)>,
    value: Box<dyn Fn([f64; 3]) -> f64 + Send + Sync>,
}

pub(super) fn planes(
    phantom: &Phantom,
    dims: Dims,
    affine: Affine,
    rescale: Rescale,
) -> AnyPlanes<'static> {
    let whole = match phantom.stored {
        StoredType::U8 => Some((0.0, f64::from(u8::MAX))),
        StoredType::I8 => Some((f64::from(i8::MIN), f64::from(i8::MAX))),
        StoredType::U16 => Some((0.0, f64::from(u16::MAX))),
        StoredType::I16 => Some((f64::from(i16::MIN), f64::from(i16::MAX))),
        StoredType::U32 => Some((0.0, f64::from(u32::MAX))),
        StoredType::I32 => Some((f64::from(i32::MIN), f64::from(i32::MAX))),
        // Whole numbers that f64 has.
        StoredType::U64 => Some((0.0, 2_f64.powi(53))),
        StoredType::I64 => Some((-(2_f64.powi(53)), 2_f64.powi(53))),
        StoredType::F32 | StoredType::F64 => None,
    };
    let field = Field {
        dims,
        affine,
        rescale,
        noise: phantom.noise,
        seed: phantom.seed,
        whole,
        value: phantom.shape.field(phantom.extent_mm(), phantom.spacing_mm),
    };
    match phantom.stored {
        StoredType::U8 => AnyPlanes::U8(made(field, |v| v as u8)),
        StoredType::I8 => AnyPlanes::I8(made(field, |v| v as i8)),
        StoredType::U16 => AnyPlanes::U16(made(field, |v| v as u16)),
        StoredType::I16 => AnyPlanes::I16(made(field, |v| v as i16)),
        StoredType::U32 => AnyPlanes::U32(made(field, |v| v as u32)),
        StoredType::I32 => AnyPlanes::I32(made(field, |v| v as i32)),
        StoredType::F32 => AnyPlanes::F32(made(field, |v| v as f32)),
        StoredType::U64 | StoredType::I64 | StoredType::F64 => AnyPlanes::F64(made(field, |v| v)),
    }
}

fn made<T: Sample>(field: Field, store: fn(f64) -> T) -> Planes<'static, T> {
    Planes::Positioned(Box::new(Made { field, store }))
}

struct Made<T> {
    field: Field,
    store: fn(f64) -> T,
}

impl<T: Sample> PositionedPlanes<T> for Made<T> {
    fn read_plane(&self, k: usize, mut out: ArrayViewMut2<'_, T>) -> Result<(), SourceError> {
        let Field { dims, affine, rescale, noise, seed, whole, value } = &self.field;
        let first = k as u64 * dims.plane_len() as u64;
        for ((j, i), out) in out.indexed_iter_mut() {
            let mut real = value(affine.apply([i as f64, j as f64, k as f64]));
            if *noise > 0.0 {
                let sample = first + j as u64 * dims.nx() as u64 + i as u64;
                real += noise * normal(*seed, sample);
            }
            let stored = rescale.level(real);
            *out = (self.store)(match whole {
                Some((low, high)) => stored.round().clamp(*low, *high),
                None => stored,
            });
        }
        Ok(())
    }
}
