//! Label maps: samples that are in or out, by the stored values that are named.

use std::ops::ControlFlow;

use super::WrapError;
use super::lend::map_planes;
use super::valid::Valid;
use crate::cancel::Cancel;
use crate::source::each::each_plane;
use crate::source::{AnyPlanes, Planes, SourceError, Volume};
use crate::volume::{Meta, Rescale, Sample, StoredType};
use crate::with_planes;

/// From here on `f64` holds several 64-bit integers as one.
const EXACT: f64 = (1_u64 << f64::MANTISSA_DIGITS) as f64;

/// 1 where the stored value is one of `values`, 0 elsewhere, to be meshed at 0.5: every vertex is
/// then the middle of its edge. Padding is 0 whatever its value; a value that the samples' type
/// cannot have is never met.
///
/// # Errors
/// [`WrapError::NotStored`] where a rescale that changes from plane to plane leaves real values alone;
/// [`WrapError::CoarseLabel`] where 64-bit integers are asked for a value of 2⁵³ or more.
pub fn mask<'a>(volume: Volume<'a>, values: &[f64]) -> Result<Volume<'a>, SourceError> {
    let Volume { mut meta, planes } = volume;
    let are_wide = matches!(planes, AnyPlanes::F32(_) | AnyPlanes::F64(_));
    if are_wide && meta.stored.size() < 8 && meta.stored != StoredType::F32 {
        return Err(WrapError::NotStored(meta.stored).into());
    }
    if matches!(meta.stored, StoredType::I64 | StoredType::U64)
        && let Some(&label) = values.iter().find(|v| v.abs() >= EXACT)
    {
        return Err(WrapError::CoarseLabel(label, meta.stored).into());
    }
    let planes = with_planes!(planes, inner => AnyPlanes::U8(marked(inner, &meta, values)));
    meta.rescale = Rescale::IDENTITY;
    (meta.padding, meta.uneven_padding) = (None, None);
    Ok(Volume { meta, planes })
}

fn marked<'a, T: Sample>(planes: Planes<'a, T>, meta: &Meta, values: &[f64]) -> Planes<'a, u8> {
    let valid = Valid::<T>::new(meta);
    let mut named: Vec<T> = values.iter().filter_map(|&v| stored(v)).collect();
    named.retain(|&v| valid.holds(v));
    named.dedup();
    // Few values are compared one by one, whole rows at a time; many are looked up where the type
    // is small enough for a table.
    let table = (named.len() > 4).then(|| table(&named)).flatten();
    map_planes(planes, meta.grid.dims, move |from, to| {
        if let Some(table) = &table {
            for (&x, mark) in from.iter().zip(to) {
                let place = (x.ordinal() - T::FIRST) as usize;
                *mark = table.get(place).copied().unwrap_or(0);
            }
            return;
        }
        to.fill(0);
        for &value in &named {
            for (&x, mark) in from.iter().zip(to.iter_mut()) {
                *mark |= u8::from(x == value);
            }
        }
    })
}

/// A mark for every value of a type of 8 or 16 bits; nothing for wider ones.
fn table<T: Sample>(named: &[T]) -> Option<Vec<u8>> {
    if size_of::<T>() > 2 {
        return None;
    }
    let mut table = vec![0; (T::LAST - T::FIRST + 1) as usize];
    for value in named {
        if let Some(mark) = table.get_mut((value.ordinal() - T::FIRST) as usize) {
            *mark = 1;
        }
    }
    Some(table)
}

/// The value of the type that is just `v`, if there is one.
fn stored<T: Sample>(v: f64) -> Option<T> {
    let (mut low, mut high) = (T::FIRST, T::LAST);
    while high.abs_diff(low) > 1 {
        let middle = i64::midpoint(low, high);
        if T::from_ordinal(middle).to_f64() <= v { low = middle } else { high = middle }
    }
    [low, high].into_iter().map(T::from_ordinal).find(|x| x.to_f64() == v)
}

/// Reads a volume to see whether its real values are 0 and one other that is greater: the level
/// halfway between them then. Nothing for any other volume, known as soon as a third value is met.
/// NaN and padding are passed over.
///
/// # Errors
/// What the source says, also of the end of its stream.
pub fn two_values(volume: Volume<'_>, cancel: &Cancel) -> Result<Option<f64>, SourceError> {
    let Volume { meta, planes } = volume;
    with_planes!(planes, inner => look(inner, &meta, cancel))
}

fn look<T: Sample>(
    planes: Planes<'_, T>,
    meta: &Meta,
    cancel: &Cancel,
) -> Result<Option<f64>, SourceError> {
    let valid = Valid::<T>::new(meta);
    let mut seen: Vec<T> = Vec::with_capacity(3);
    each_plane(planes, meta.grid.dims, cancel, |samples| {
        for &x in samples {
            if !seen.contains(&x) && valid.holds(x) {
                seen.push(x);
                if seen.len() > 2 {
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(())
    })?;
    let real = |x: &T| meta.rescale.real(x.to_f64());
    let [a, b] = seen.as_slice() else { return Ok(None) };
    let (low, high) = (real(a).min(real(b)), real(a).max(real(b)));
    Ok((low == 0.0 && high.is_finite()).then_some(high / 2.0))
}
