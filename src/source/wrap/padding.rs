//! Padding whose own value would be inside: taken out, so that it acts as NaN.

use super::lend::map_planes;
use super::valid::within;
use crate::source::{AnyPlanes, Planes, Volume};
use crate::volume::{Meta, Rescale, Sample};
use crate::with_planes;

/// Whether a real value is inside.
fn is_inside(real: f64, iso: f64, below: bool) -> bool {
    if below { real < iso } else { real >= iso }
}

/// Whether any value of the volume's padding would be inside at `iso`: inside is value ≥ iso, or
/// value < iso where `below`. Padding is outside in any case, so where this is false nothing need
/// be done about it.
pub fn is_active(meta: &Meta, iso: f64, below: bool) -> bool {
    // Real values are monotone over the range, so one of its ends is inside if any value is.
    meta.padding.is_some_and(|p| {
        [p.low, p.high].iter().any(|&x| is_inside(meta.rescale.real(x), iso, below))
    })
}

/// The same stored values in `f64`, NaN where a sample is padding and its own value would be inside
/// at `iso`: outside, and an edge to it has its vertex in the middle. Padding that is outside by
/// its own value stays as it is. The volume unchanged where padding is not active.
pub fn pad_out(volume: Volume<'_>, iso: f64, below: bool) -> Volume<'_> {
    if !is_active(&volume.meta, iso, below) {
        return volume;
    }
    let Volume { mut meta, planes } = volume;
    let planes = with_planes!(planes, inner => AnyPlanes::F64(without(inner, &meta, iso, below)));
    meta.padding = None;
    Volume { meta, planes }
}

fn without<'a, T: Sample>(
    planes: Planes<'a, T>,
    meta: &Meta,
    iso: f64,
    below: bool,
) -> Planes<'a, f64> {
    let rescale: Rescale = meta.rescale;
    let padding = meta.padding.and_then(within::<T>);
    map_planes(planes, meta.grid.dims, move |from, to| {
        for (&x, value) in from.iter().zip(to) {
            let stored = x.to_f64();
            let out = padding.as_ref().is_some_and(|p| p.contains(&x))
                && is_inside(rescale.real(stored), iso, below);
            *value = if out { f64::NAN } else { stored };
        }
    })
}
