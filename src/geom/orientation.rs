//! The letters of an affine: which way each voxel axis points.

use super::Affine;
use super::vec3::{Vec3, cross, dot, norm, scale};

/// For each of the axes i, j, k the letter of the direction it points to (R or L, A or P, S or I),
/// as nibabel's `aff2axcodes` gives them; `?` where an axis has no direction of its own.
///
/// The directions are those of the rotation nearest to the affine, shear and zooms removed. The
/// axis that lies closest to one of R, A, S is named first, and each of them is used once.
///
/// ```
/// use mcubes::geom::{Affine, orientation};
///
/// let flipped = Affine::from_columns([-2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.1, 2.0], [0.0; 3]);
/// assert_eq!(orientation(&flipped), "LAS");
/// ```
pub fn orientation(affine: &Affine) -> String {
    let columns = [0, 1, 2].map(|c| affine.column(c));
    let Some(rotation) = nearest_rotation(columns) else { return "???".to_owned() };
    let strength = |c: usize| rotation[c].iter().fold(0.0_f64, |m, v| m.max(v * v));
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)));
    let mut letters = ['?'; 3];
    let mut used = [false; 3];
    for axis in order {
        let mut best: Option<usize> = None;
        for d in (0..3).filter(|&d| !used[d]) {
            if best.is_none_or(|b| rotation[axis][d].abs() > rotation[axis][b].abs()) {
                best = Some(d);
            }
        }
        // nibabel takes anything within 1e-8 for no direction.
        let Some(direction) = best.filter(|&d| rotation[axis][d].abs() > 1e-8) else { continue };
        used[direction] = true;
        let positive = rotation[axis][direction] > 0.0;
        letters[axis] = [['L', 'R'], ['P', 'A'], ['I', 'S']][direction][usize::from(positive)];
    }
    letters.iter().collect()
}

/// The orthogonal factor of the polar decomposition of the matrix with these columns, each brought
/// to unit length first; nothing where they are not finite or not independent.
///
/// By Newton's iteration `X ← (γX + X⁻ᵀ/γ) / 2` (Higham, "Computing the polar decomposition",
/// 1986), with γ from the Frobenius norms.
fn nearest_rotation(columns: [Vec3; 3]) -> Option<[Vec3; 3]> {
    let mut x = columns.map(|c| {
        let largest = c.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let c = scale(c, 1.0 / largest);
        scale(c, 1.0 / norm(c))
    });
    for _ in 0..64 {
        // The columns of X⁻ᵀ are the cross products over the determinant.
        let determinant = dot(cross(x[0], x[1]), x[2]);
        let inverse = [cross(x[1], x[2]), cross(x[2], x[0]), cross(x[0], x[1])]
            .map(|c| scale(c, 1.0 / determinant));
        let size = |m: &[Vec3; 3]| m.iter().map(|c| dot(*c, *c)).sum::<f64>();
        let gamma = (size(&inverse) / size(&x)).powf(0.25);
        let next: [Vec3; 3] = std::array::from_fn(|c| {
            std::array::from_fn(|r| 0.5 * (gamma * x[c][r] + inverse[c][r] / gamma))
        });
        if !next.iter().flatten().all(|v| v.is_finite()) {
            return None;
        }
        let moved = (0..3).flat_map(|c| (0..3).map(move |r| (c, r)));
        let moved = moved.map(|(c, r)| (next[c][r] - x[c][r]).abs()).fold(0.0, f64::max);
        x = next;
        if moved < 1e-14 {
            break;
        }
    }
    Some(x)
}
