//! From a real iso value to the first stored value that is inside.

use crate::volume::{Inside, Rescale, Sample, Side};

/// The stored values that are inside: all those on one side of a stored value, it included. NaN
/// never is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cut<T> {
    /// x ≥ the value.
    From(T),
    /// x ≤ the value.
    UpTo(T),
    /// No stored value is inside.
    Nothing,
}

impl<T: Sample> Cut<T> {
    /// Finds the cut by bisection over all values of the type in order, so that for each of them it
    /// says just what the rescaled value in `f64`, compared with `iso`, says. Rounding is monotone,
    /// so there is one step; a negative slope turns it round.
    pub(super) fn new(rescale: Rescale, iso: f64, side: Side) -> Self {
        let asked = Inside { iso, side };
        let inside = |ordinal| asked.holds(rescale.real(T::from_ordinal(ordinal).to_f64()));
        let upward = (side == Side::AtLeast) == (rescale.slope() > 0.0);
        // Inside holds at one end of the order; step towards the other until it no longer does.
        let (end, start) = if upward { (T::LAST, T::FIRST) } else { (T::FIRST, T::LAST) };
        if !inside(end) {
            return Self::Nothing;
        }
        let (mut held, mut failed) = (end, start);
        if inside(start) {
            held = start;
        } else {
            while held.abs_diff(failed) > 1 {
                let middle = i64::midpoint(held, failed);
                if inside(middle) { held = middle } else { failed = middle }
            }
        }
        let at = T::from_ordinal(held);
        if upward { Self::From(at) } else { Self::UpTo(at) }
    }

    /// Whether a stored value is inside: what the bit planes hold.
    #[cfg(test)]
    fn holds(self, x: T) -> bool {
        match self {
            Self::From(at) => x >= at,
            Self::UpTo(at) => x <= at,
            Self::Nothing => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_i16_is_on_the_side_that_the_formula_says() {
        let rescales = [(1.0, 0.0), (0.1, -1024.0), (-0.37, 12.5), (7.1, 3e5), (1e-20, 0.0)];
        let isos = [0.0, 300.0, -1024.0, -0.5, 1e9, -1e9, 1e-16, 0.1 * 77.0 - 1024.0];
        for (slope, inter) in rescales {
            let rescale = Rescale::new(slope, inter).unwrap();
            for iso in isos {
                for side in [Side::AtLeast, Side::Below] {
                    let cut = Cut::<i16>::new(rescale, iso, side);
                    for x in i16::MIN..=i16::MAX {
                        let real = f64::from(x) * slope + inter;
                        let expected = if side == Side::AtLeast { real >= iso } else { real < iso };
                        assert_eq!(cut.holds(x), expected, "{x} at {slope} {inter} {iso} {side:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn floats_next_to_the_threshold_are_told_apart() {
        let rescale = Rescale::new(0.1, 0.7).unwrap();
        let cut = Cut::<f32>::new(rescale, 1.0, Side::AtLeast);
        let Cut::From(at) = cut else { panic!("{cut:?}") };
        assert!(f64::from(at) * 0.1 + 0.7 >= 1.0);
        assert!(f64::from(at.next_down()) * 0.1 + 0.7 < 1.0);
        assert!(!cut.holds(f32::NAN) && cut.holds(f32::INFINITY));
        let below = Cut::<f64>::new(Rescale::IDENTITY, 0.0, Side::Below);
        assert!(!below.holds(f64::NAN) && !below.holds(-0.0) && below.holds(-5e-324));
    }
}
