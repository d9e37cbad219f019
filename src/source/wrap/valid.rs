//! Which samples stand for something: neither NaN nor padding.

use std::ops::RangeInclusive;

use crate::volume::{Meta, Padding, Sample, StoredType};

/// Tells the samples of one type that count from those that do not.
#[derive(Clone, Debug)]
pub(super) struct Valid<T> {
    padding: Option<RangeInclusive<T>>,
    has_nan: bool,
}

impl<T: Sample> Valid<T> {
    pub(super) fn new(meta: &Meta) -> Self {
        let has_nan = matches!(T::TYPE, StoredType::F32 | StoredType::F64);
        Self { padding: meta.padding.and_then(within::<T>), has_nan }
    }

    /// Whether every value of the type counts.
    pub(super) fn all(&self) -> bool {
        self.padding.is_none() && !self.has_nan
    }

    /// Whether a sample counts.
    pub(super) fn holds(&self, x: T) -> bool {
        // A NaN differs from itself.
        let number = x.partial_cmp(&x).is_some();
        number && !self.padding.as_ref().is_some_and(|p| p.contains(&x))
    }
}

/// The values of the type that lie in a range of padding, if there are any.
pub(super) fn within<T: Sample>(padding: Padding) -> Option<RangeInclusive<T>> {
    let first = bisect(|x: T| x.to_f64() >= padding.low)?;
    let last = bisect(|x: T| x.to_f64() > padding.high).map_or(T::LAST, |k| k - 1);
    (first <= last).then(|| T::from_ordinal(first)..=T::from_ordinal(last))
}

/// The place of the first value at which a condition holds that holds from there on.
fn bisect<T: Sample>(holds: impl Fn(T) -> bool) -> Option<i64> {
    if !holds(T::from_ordinal(T::LAST)) {
        return None;
    }
    let (mut low, mut high) = (T::FIRST, T::LAST);
    while low < high {
        let middle = i64::midpoint(low, high);
        // Rounds down, also below zero, so that the two close in on one another.
        let middle = if middle == high { low } else { middle };
        if holds(T::from_ordinal(middle)) { high = middle } else { low = middle + 1 }
    }
    Some(low)
}
