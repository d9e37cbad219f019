//! Where the surface meets a grid edge.

/// The part of the way from the lower sample `a` to the upper sample `b` at which the linear
/// interpolant takes the value `level`, clamped to `[epsilon, 1 - epsilon]`; ½ where `a`, `b` or
/// `b - a` is not finite. In `f64`, no fused multiply-add.
///
/// The definition: `simd::vertices512` does the same for sixteen edges. Settled cells and normals,
/// which need t again, ask with the same ends in the same order.
#[inline(always)]
pub fn crossing(a: f64, b: f64, level: f64, epsilon: f64) -> f64 {
    let rise = b - a;
    // A level equal to an end, or (after rounding) beyond it, is clamped; 0/0 cannot be, since the
    // ends differ in side and so in value.
    let t = ((level - a) / rise).max(epsilon).min(1.0 - epsilon);
    // Two finite ends may still be too far apart for their difference; an end that is not finite
    // makes the difference so too, unless both are infinite alike or NaN, which make it NaN.
    if rise.is_finite() { t } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_linear_between_its_clamps() {
        assert_eq!(crossing(0.0, 4.0, 1.0, 0.001), 0.25);
        assert_eq!(crossing(4.0, 0.0, 1.0, 0.001), 0.75);
        assert_eq!(crossing(1.0, 4.0, 1.0, 0.001), 0.001);
        assert_eq!(crossing(0.0, 1.0, 1.0, 0.001), 0.999);
    }

    #[test]
    fn is_the_middle_where_an_end_is_not_finite() {
        for (a, b) in [
            (f64::NAN, 1.0),
            (1.0, f64::NAN),
            (f64::INFINITY, 1.0),
            (f64::NEG_INFINITY, f64::INFINITY),
            (-1.2e308, 1.2e308),
        ] {
            assert_eq!(crossing(a, b, 0.5, 0.001), 0.5);
        }
    }
}
