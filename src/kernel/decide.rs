//! The deciders: what the trilinear interpolant does on an ambiguous face and inside a cell.
//!
//! Products and sums in `f64`, never fused, so that a face's two cells compute the same bits.
//! Knows values, no rows of the tables and no vertices.

use super::tables::cube::slice_corners;

/// Whether the two inside corners of an ambiguous face are joined across it, by the asymptotic
/// decider (Nielson and Hamann 1991). Both pairs are values less the level, positive inside. A tie
/// or a value that is not finite does not join.
///
/// The same for both cells at the face without any agreement on an order, since a product does not
/// depend on the order of its factors, and inside is inside from either side.
pub(super) fn joins(inside: [f64; 2], outside: [f64; 2]) -> bool {
    let difference = inside[0] * inside[1] - outside[0] * outside[1];
    if difference != 0.0 && difference.is_finite() {
        return difference > 0.0;
    }
    // Products out of range are brought into it by a power of two, which both cells find alike.
    let [a, b] = inside;
    let [c, d] = outside;
    let most = a.abs().max(b.abs()).max(c.abs().max(d.abs()));
    let by = if most > 1e150 {
        LARGE.recip()
    } else if most < 1e-150 {
        LARGE
    } else {
        return false;
    };
    let difference = (a * by) * (b * by) - (c * by) * (d * by);
    difference > 0.0 && difference.is_finite()
}

/// 2^520.
const LARGE: f64 = f64::from_bits((1023 + 520) << 52);

/// The hexagon in which three asymptotic planes of either direction meet the surface, inside the
/// cell: the waist of a tunnel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waist {
    /// Whether it joins inside corners; else it joins outside corners.
    pub(super) inside: bool,
    /// The middle of the box of which the hexagon holds six corners.
    pub(super) middle: [f64; 3],
    /// Half the box along each axis, with the sign of `alpha`: the box runs between the point
    /// `middle + half` and the point `middle - half`, the two corners that the hexagon leaves out.
    pub(super) half: [f64; 3],
}

/// The waist of the tunnel that the surface may have inside a cell, if both roots of the asymptotic
/// decider, taken as a quadratic along each axis, lie in it. `values` are those of the corners, less
/// the level. Not to be asked of a cell whose surface is a single loop's.
pub(super) fn waist(values: &[f64; 8]) -> Option<Waist> {
    let values = in_range(values)?;
    let mut middle = [0.0; 3];
    let mut half = [0.0; 3];
    let mut root = 0.0;
    for axis in 0..3 {
        let [a, b] = [0, 1].map(|side| slice_corners(axis, side).map(|i| values[i]));
        let e = [0, 1, 2, 3].map(|k| b[k] - a[k]);
        let alpha = e[0] * e[2] - e[1] * e[3];
        let beta = a[0] * e[2] + a[2] * e[0] - a[1] * e[3] - a[3] * e[1];
        let gamma = a[0] * a[2] - a[1] * a[3];
        let delta = b[0] * b[2] - b[1] * b[3];
        let is_within = alpha * gamma > 0.0
            && alpha * delta > 0.0
            && alpha * beta < 0.0
            && alpha * (beta + 2.0 * alpha) > 0.0;
        if !is_within {
            return None;
        }
        if axis == 0 {
            // The same number for all axes: Cayley's hyperdeterminant of the eight values.
            let discriminant = beta * beta - 4.0 * alpha * gamma;
            if discriminant > 0.0 {
                root = discriminant.sqrt();
            } else {
                return None;
            }
        }
        middle[axis] = -beta / (2.0 * alpha);
        half[axis] = root / (2.0 * alpha);
    }
    Some(Waist { inside: trilinear(&values, middle) >= 0.0, middle, half })
}

/// The value of the trilinear interpolant at a point of the cell.
pub(super) fn trilinear(values: &[f64; 8], [x, y, z]: [f64; 3]) -> f64 {
    let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
    let [near, far] = [0, 4].map(|k| {
        let low = mix(values[k], values[k + 1], x);
        let high = mix(values[k + 2], values[k + 3], x);
        mix(low, high, y)
    });
    mix(near, far, z)
}

/// The gradient of the trilinear interpolant at a point of the cell.
pub(super) fn gradient(values: &[f64; 8], at: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let end = |side: f64| {
            let mut place = at;
            place[axis] = side;
            trilinear(values, place)
        };
        end(1.0) - end(0.0)
    })
}

/// The values by a power of two such that products of four of them are in range; nothing where one
/// is not finite.
fn in_range(values: &[f64; 8]) -> Option<[f64; 8]> {
    let most = values.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    if !values.iter().all(|v| v.is_finite()) {
        return None;
    }
    if most == 0.0 || (1e-70..1e70).contains(&most) {
        return Some(*values);
    }
    let exponent = (most.to_bits() >> 52) as i64 - 1023;
    // In two steps, since the power itself may be out of range.
    let (first, second) = (-exponent / 2, -exponent - -exponent / 2);
    let power = |k: i64| f64::from_bits(((1023 + k) as u64) << 52);
    Some(values.map(|v| v * power(first) * power(second)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_join_by_the_sign_of_the_exact_difference() {
        assert!(joins([3.0, 2.0], [-1.0, -5.0]));
        assert!(!joins([1.0, 5.0], [-3.0, -2.0]));
        assert!(!joins([2.0, 3.0], [-1.0, -6.0]), "a tie");
        assert!(joins([3e200, 2e200], [-1e200, -5e200]));
        assert!(!joins([1e-200, 5e-200], [-3e-200, -2e-200]));
        assert!(!joins([f64::INFINITY, 1.0], [-1.0, -1.0]));
        assert!(!joins([f64::NAN, 1.0], [-1.0, -1.0]));
        for i in 0..10_000i64 {
            let [a, b, c, d] = [7, 11, 13, 17].map(|k| (i * k * 7919) % 65_536);
            let exact = a * b > c * d;
            assert_eq!(joins([a as f64, b as f64], [-c as f64, -d as f64]), exact);
        }
    }

    #[test]
    fn a_waist_is_found_at_every_scale_and_nowhere_in_bad_values() {
        // Two opposite corners inside, nearly joined through the middle.
        let mut values = [-1.0; 8];
        (values[0], values[7]) = (10.0, 10.0);
        assert!(waist(&values).is_some_and(|w| w.inside));
        assert!(waist(&values.map(|v| -v)).is_some_and(|w| !w.inside));
        for by in [1e300, 1e-300, 1e-320, 1e90, 1e-90] {
            assert!(waist(&values.map(|v| v * by)).is_some(), "{by}");
        }
        (values[0], values[7]) = (2.0, 2.0);
        assert!(waist(&values).is_none());
        values[3] = f64::NAN;
        assert!(waist(&values).is_none());
    }
}
