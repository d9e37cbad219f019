//! Padding whose own value would be inside: taken out, so that it acts as NaN.

use super::lend::map_planes;
use super::valid::within;
use crate::source::{AnyPlanes, Planes, Volume};
use crate::volume::{Inside, Meta, Padding, Sample};
use crate::with_planes;

/// Whether any value of the volume's padding would be inside. Padding is outside in any case, so
/// where this is false nothing need be done about it but to give it its own values.
pub fn is_active(meta: &Meta, inside: Inside) -> bool {
    // Real values are monotone over a range, so one of its ends is inside if any value is.
    let any = |p: Padding, real: &dyn Fn(f64) -> f64| {
        inside.holds(real(p.low)) || inside.holds(real(p.high))
    };
    meta.padding.is_some_and(|p| any(p, &|x| meta.rescale.real(x)))
        || meta.uneven_padding.is_some_and(|p| any(p, &|x| x))
}

/// The same stored values, NaN where a sample is padding and its own value would be inside:
/// outside, and an edge to it has its vertex in the middle. Padding that is outside by its own
/// value has that value. In `f64`; the volume unchanged where its padding is one range and not
/// active.
pub fn pad_out(volume: Volume<'_>, inside: Inside) -> Volume<'_> {
    let is_active = is_active(&volume.meta, inside);
    let Volume { mut meta, mut planes } = volume;
    if meta.uneven_padding.take().is_some() {
        if let AnyPlanes::F64(Planes::Positioned(inner)) = &mut planes {
            inner.keep_padding(inside);
        }
    } else if is_active {
        planes = with_planes!(planes, inner => AnyPlanes::F64(without(inner, &meta, inside)));
        meta.padding = None;
    }
    Volume { meta, planes }
}

fn without<'a, T: Sample>(planes: Planes<'a, T>, meta: &Meta, inside: Inside) -> Planes<'a, f64> {
    let rescale = meta.rescale;
    let padding = meta.padding.and_then(within::<T>);
    map_planes(planes, meta.grid.dims, move |from, to| {
        for (&x, value) in from.iter().zip(to) {
            let stored = x.to_f64();
            let out = padding.as_ref().is_some_and(|p| p.contains(&x))
                && inside.holds(rescale.real(stored));
            *value = if out { f64::NAN } else { stored };
        }
    })
}
