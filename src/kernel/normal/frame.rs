//! Directions in output space from slopes along the grid's axes.

use crate::geom::Place;
use crate::geom::vec3::{Vec3, cross, dot};
use crate::mesh::Normal;

/// The inverse transpose of the map from steps along i, j and k to output space, up to a positive
/// factor: what turns a field's slopes a step into the direction in which it rises.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    columns: [Vec3; 3],
}

impl Frame {
    /// For the steps along i, j and k, which may form a left-handed frame.
    pub(super) fn new(steps: [Vec3; 3]) -> Self {
        let [i, j, k] = scaled_to_one(steps);
        let columns = scaled_to_one([cross(j, k), cross(k, i), cross(i, j)]);
        let hand = 1f64.copysign(dot(cross(i, j), k));
        Self { columns: columns.map(|column| column.map(|x| x * hand)) }
    }

    /// The direction that each of the three slopes gives, times `by`.
    pub(super) fn times(&self, by: f64) -> [Vec3; 3] {
        self.columns.map(|column| column.map(|x| x * by))
    }

    /// The direction in which a field with these slopes rises; its length says nothing.
    fn turn(&self, slopes: Vec3) -> Vec3 {
        let [i, j, k] = &self.columns;
        let along = |axis: usize| i[axis] * slopes[0] + j[axis] * slopes[1] + k[axis] * slopes[2];
        [along(0), along(1), along(2)]
    }

    /// The unit vector that stands for this direction along the grid's axes.
    pub(super) fn direction(&self, outward: Vec3) -> Normal {
        self.unit(outward).unwrap_or(UPWARD)
    }

    /// The unit vector in that direction, whatever the size of the slopes; nothing where they are
    /// all zero or one is not finite.
    pub(super) fn unit(&self, slopes: Vec3) -> Option<Normal> {
        let most = slopes.iter().fold(0f64, |most, x| most.max(x.abs()));
        if !(most > 0.0 && slopes.iter().all(|x| x.is_finite())) {
            return None;
        }
        let n = self.turn(slopes.map(|x| x / most));
        let length = dot(n, n).sqrt();
        // No negative zeroes, which look odd in text.
        Some(n.map(|x| (x / length) as f32 + 0.0))
    }
}

/// What stands for a direction where there is none, which no volume has.
const UPWARD: Normal = [0.0, 0.0, 1.0];

/// By one factor, so that the largest number is 1 or -1.
fn scaled_to_one(vectors: [Vec3; 3]) -> [Vec3; 3] {
    let most = vectors.iter().flatten().fold(0f64, |most, x| most.max(x.abs()));
    vectors.map(|v| v.map(|x| x / most))
}

/// How the samples of a plane, of the one before it and of the one after it give the slope along k.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::kernel) struct Across {
    /// Factors of the differences to the plane before and to the one after.
    pub(in crate::kernel) weights: [f64; 2],
    /// How much of the slopes along i and j that has in it, to be taken off.
    pub(in crate::kernel) lean: [f64; 2],
}

impl Across {
    /// At plane `k` of `nz`, and the step along which it gives the slope: the three-point formula
    /// over the true distances between planes, one-sided at the first and the last plane.
    pub(super) fn at(place: &Place, k: i64, nz: usize) -> (Self, Vec3) {
        let (before, after) = (place.step_k(k - 1), place.step_k(k));
        let is_last = k + 1 >= nz as i64;
        let (weights, step) = match (k <= 0, is_last) {
            (true, true) => ([0.0, 0.0], after),
            (true, false) => ([0.0, 1.0], after),
            (false, true) => ([1.0, 0.0], before),
            (false, false) if before == after => ([0.5, 0.5], after),
            (false, false) => {
                let normal = cross(place.step_i(), place.step_j());
                let ratio = dot(normal, after) / dot(normal, before);
                // Planes in rising order; where they are not, as if they were even.
                let ratio = if ratio > 0.0 && ratio.is_finite() { ratio } else { 1.0 };
                let weights = [0.5 * ratio, 0.5 / ratio];
                let step = |axis: usize| weights[0] * before[axis] + weights[1] * after[axis];
                (weights, [step(0), step(1), step(2)])
            }
        };
        (Self { weights, lean: [0.0; 2] }, step)
    }

    /// The same, giving the slope along `step` instead.
    pub(super) fn along(place: &Place, k: i64, nz: usize, step: Vec3) -> Self {
        let (across, own) = Self::at(place, k, nz);
        if own == step {
            return across;
        }
        // own = part · step + lean[0] · step_i + lean[1] · step_j
        let (i, j) = (place.step_i(), place.step_j());
        let volume = dot(cross(i, j), step);
        let lean = [dot(cross(j, step), own) / volume, dot(cross(step, i), own) / volume];
        let part = dot(cross(i, j), own) / volume;
        Self { weights: across.weights.map(|w| w / part), lean: lean.map(|x| x / part) }
    }
}
