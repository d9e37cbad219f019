//! The map from voxel indices to millimetres.

use super::vec3::{Vec3, cross, dot, norm, scale};

/// A 3 × 4 matrix in `f64`, rows first: `(i, j, k, 1)` to a point, normally RAS millimetres.
///
/// ```text
/// x   | m00 m01 m02 m03 |   | i |
/// y = | m10 m11 m12 m13 | · | j |     columns 0..2: one step along i, j, k
/// z   | m20 m21 m22 m23 |   | k |     column 3:     the centre of sample (0, 0, 0)
///                           | 1 |
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    rows: [[f64; 4]; 3],
}

impl Affine {
    /// Index coordinates as they are.
    pub const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// From rows, as drawn above.
    pub const fn from_rows(rows: [[f64; 4]; 3]) -> Self {
        Self { rows }
    }

    /// From the steps along i, j, k and the centre of sample (0, 0, 0).
    pub fn from_columns(i: Vec3, j: Vec3, k: Vec3, origin: Vec3) -> Self {
        let row = |r: usize| [i[r], j[r], k[r], origin[r]];
        Self { rows: [row(0), row(1), row(2)] }
    }

    /// The rows, as drawn above.
    pub fn rows(&self) -> &[[f64; 4]; 3] {
        &self.rows
    }

    /// A column: the step along i (0), j (1), k (2), or the origin (3).
    pub fn column(&self, c: usize) -> Vec3 {
        [self.rows[0][c], self.rows[1][c], self.rows[2][c]]
    }

    /// The image of a point.
    pub fn apply(&self, p: Vec3) -> Vec3 {
        self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3])
    }

    /// The map that applies `first`, then `self`.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        let turn = |v: Vec3| self.rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2]);
        let [i, j, k] = [0, 1, 2].map(|c| turn(first.column(c)));
        Self::from_columns(i, j, k, self.apply(first.column(3)))
    }

    /// The map back; nothing where the map is not usable.
    pub fn inverse(&self) -> Option<Self> {
        if !self.is_usable() {
            return None;
        }
        let [a, b, c] = [0, 1, 2].map(|n| self.column(n));
        // Rows of the inverse are the cross products over the determinant (Cramer).
        let d = self.determinant();
        let rows = [cross(b, c), cross(c, a), cross(a, b)].map(|r| r.map(|v| v / d));
        let o = self.column(3);
        let rows = rows.map(|r| [r[0], r[1], r[2], -dot(r, o)]);
        rows.iter().flatten().all(|v| v.is_finite()).then_some(Self { rows })
    }

    /// Millimetres between samples along i, j, k.
    pub fn spacing(&self) -> Vec3 {
        [norm(self.column(0)), norm(self.column(1)), norm(self.column(2))]
    }

    /// The angle between the step along k and the normal of the plane of i and j, in degrees, from 0
    /// to 90.
    pub fn tilt_degrees(&self) -> f64 {
        // Unit vectors, since products of lengths may overflow.
        let [i, j, k] = [0, 1, 2].map(|c| scale(self.column(c), 1.0 / norm(self.column(c))));
        let normal = cross(i, j);
        norm(cross(k, normal)).atan2(dot(k, normal).abs()).to_degrees()
    }

    /// The determinant of the linear part: negative where the map mirrors.
    pub fn determinant(&self) -> f64 {
        dot(cross(self.column(0), self.column(1)), self.column(2))
    }

    /// Whether every number is finite and the linear part can be inverted.
    pub fn is_usable(&self) -> bool {
        self.rows.iter().flatten().all(|v| v.is_finite())
            && self.least_singular_value() > 1e-6 * self.spacing().iter().fold(0.0, |m, v| v.max(m))
    }

    /// The smallest stretch of the linear part: a unit step in any direction of index space moves
    /// the image at least this far.
    ///
    /// From the eigenvalues of `AᵀA` in closed form (Smith 1961), on A scaled to avoid overflow.
    pub fn least_singular_value(&self) -> f64 {
        let columns = [self.column(0), self.column(1), self.column(2)];
        let size = columns.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
        if !(size > 0.0 && size.is_finite()) {
            return 0.0;
        }
        let c = columns.map(|v| v.map(|x| x / size));
        let gram = |a: usize, b: usize| dot(c[a], c[b]);
        let (d0, d1, d2) = (gram(0, 0), gram(1, 1), gram(2, 2));
        let (o01, o02, o12) = (gram(0, 1), gram(0, 2), gram(1, 2));
        let mean = (d0 + d1 + d2) / 3.0;
        let (e0, e1, e2) = (d0 - mean, d1 - mean, d2 - mean);
        let off = o01 * o01 + o02 * o02 + o12 * o12;
        let p = ((e0 * e0 + e1 * e1 + e2 * e2 + 2.0 * off) / 6.0).sqrt();
        if p <= f64::EPSILON * mean {
            return size * mean.sqrt();
        }
        let determinant = e0 * (e1 * e2 - o12 * o12) - o01 * (o01 * e2 - o12 * o02)
            + o02 * (o01 * o12 - e1 * o02);
        let r = (determinant / (2.0 * p * p * p)).clamp(-1.0, 1.0);
        let angle = r.acos() / 3.0 + 2.0 * std::f64::consts::FRAC_PI_3;
        let closed = (mean + 2.0 * p * angle.cos()).max(0.0).sqrt();
        // The closed form loses digits when one value is far below the others; the volume over the
        // product of the two larger ones does not.
        let largest = (mean + 2.0 * p * (r.acos() / 3.0).cos()).max(0.0);
        let middle = (3.0 * mean - largest - closed * closed).max(0.0);
        let volume = dot(cross(c[0], c[1]), c[2]).abs();
        let product = (largest * middle).sqrt();
        size * if product > 0.0 { volume / product } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_singular_value_of_a_diagonal_is_its_least_entry() {
        let a = Affine::from_columns([-3.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 20.0], [0.0; 3]);
        assert!((a.least_singular_value() - 0.5).abs() < 1e-9);
        assert!((Affine::IDENTITY.least_singular_value() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn tilt_is_the_angle_that_the_slices_lean_by() {
        let leaning = |y: f64, z: f64| {
            Affine::from_columns([0.0, 2.0, 0.0], [-3.0, 0.0, 0.0], [0.0, y, z], [7.0; 3])
        };
        assert_eq!(leaning(0.0, -4.0).tilt_degrees(), 0.0);
        for (y, z, degrees) in [(1.0, 1.0, 45.0), (-2.0, -2.0, 45.0), (1e-9, 1.0, 5.7296e-8)] {
            let tilt = leaning(y, z).tilt_degrees();
            assert!((tilt - degrees).abs() <= 1e-5 * degrees, "{y} {z}: {tilt}");
        }
    }

    #[test]
    fn a_flat_map_is_not_usable() {
        let a = Affine::from_columns([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3]);
        assert!(!a.is_usable());
        assert!(a.least_singular_value() < 1e-9);
    }
}
