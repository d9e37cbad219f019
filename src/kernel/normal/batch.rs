//! The gradients of many edges side by side, as loops that a compiler makes vectors of.
//!
//! One step a loop, over arrays, without branches; the same bits whatever the width of vectors.

use super::frame::Across;
use crate::kernel::crossing;
use crate::mesh::Normal;
use crate::volume::Sample;

/// Edges worked on side by side.
pub(super) const BATCH: usize = 64;

/// The samples of an edge from `a` to `b`, and those around it.
#[derive(Clone, Copy)]
pub(in crate::kernel) struct Star<S> {
    pub(in crate::kernel) a: S,
    pub(in crate::kernel) b: S,
    /// Along the edge: the one before a, and the one after b.
    pub(in crate::kernel) outer: [S; 2],
    /// Along the first other axis: the one before and the one after a, then those of b.
    pub(in crate::kernel) first: [[S; 2]; 2],
    /// The same along the second other axis.
    pub(in crate::kernel) second: [[S; 2]; 2],
}

/// A gradient leads against its edge where it leans back by more than this: the square of the
/// cotangent of 14 degrees.
pub(in crate::kernel) const AGAINST: f32 = 16.0;

/// What the gradients of one family of edges are made with.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Making {
    pub(in crate::kernel) level: f64,
    pub(in crate::kernel) epsilon: f64,
    /// For the planes of `a` and of `b`.
    pub(in crate::kernel) across: [Across; 2],
    /// Outward directions of slopes along i, j and k.
    pub(in crate::kernel) columns: [[f32; 3]; 3],
    /// What the squares of slopes along i, j and k are multiplied by to be compared.
    pub(in crate::kernel) squares: [f32; 3],
}

/// Edges whose neighbours are all there, on their way from samples to normals.
pub(super) struct Batch<T> {
    pub(super) samples: Star<[T; BATCH]>,
    t: [f32; BATCH],
    /// b - a.
    rise: [f32; BATCH],
    along: [f32; BATCH],
    /// Along the other two axes.
    first: [f32; BATCH],
    second: [f32; BATCH],
    x: [f32; BATCH],
    y: [f32; BATCH],
    z: [f32; BATCH],
    /// The squares of lengths before they were made 1.
    square: [f32; BATCH],
}

/// From the lower end's slope to the upper one's.
#[inline(always)]
fn mix(t: f32, a: f32, b: f32) -> f32 {
    (1.0 - t) * a + t * b
}

impl<T: Sample> Batch<T> {
    pub(super) fn new() -> Self {
        let (none, no_samples) = ([0.0; BATCH], [T::default(); BATCH]);
        Self {
            samples: Star {
                a: no_samples,
                b: no_samples,
                outer: [no_samples; 2],
                first: [[no_samples; 2]; 2],
                second: [[no_samples; 2]; 2],
            },
            t: none,
            rise: none,
            along: none,
            first: none,
            second: none,
            x: none,
            y: none,
            z: none,
            square: none,
        }
    }

    /// Makes normals of the samples.
    #[inline(always)]
    pub(super) fn make<const AXIS: usize>(&mut self, with: &Making) {
        self.crossings(with);
        self.slopes::<AXIS>(with);
        self.turn::<AXIS>(with);
    }

    /// The normal of edge `l` of the batch, of length 1 if [`Batch::is_usual`].
    #[inline(always)]
    pub(super) fn normal(&self, l: usize) -> Normal {
        [self.x[l], self.y[l], self.z[l]]
    }

    /// Whether the squares could be taken: not of zero, not of numbers too large or too small.
    #[inline(always)]
    pub(super) fn is_usual(&self, l: usize) -> bool {
        usual(self.square[l])
    }

    /// Whether that holds for the first `n`.
    #[inline(always)]
    pub(super) fn all_usual(&self, n: usize) -> bool {
        self.square[..n.min(BATCH)].iter().fold(true, |all, &square| all & usual(square))
    }

    /// t and the rise along each edge.
    #[inline(always)]
    fn crossings(&mut self, with: &Making) {
        let Star { a, b, .. } = &self.samples;
        for l in 0..BATCH {
            self.rise[l] = b[l].minus(a[l]);
            let (a, b) = (a[l].to_f64(), b[l].to_f64());
            self.t[l] = crossing(a, b, with.level, with.epsilon) as f32;
        }
    }

    #[inline(always)]
    fn slopes<const AXIS: usize>(&mut self, with: &Making) {
        let Star { a, b, outer, first, second } = &self.samples;
        let [before, after] = outer;
        let central = |low: T, high: T| 0.5 * high.minus(low);
        let [low, high] = with.across.map(|across| across.weights.map(|x| x as f32));
        for l in 0..BATCH {
            let [at_a, at_b] = first.each_ref().map(|[low, high]| central(low[l], high[l]));
            self.first[l] = mix(self.t[l], at_a, at_b);
        }
        if AXIS == 2 {
            for l in 0..BATCH {
                let [at_a, at_b] = second.each_ref().map(|[low, high]| central(low[l], high[l]));
                self.second[l] = mix(self.t[l], at_a, at_b);
            }
            for l in 0..BATCH {
                let rise = self.rise[l];
                let low = low[0] * a[l].minus(before[l]) + low[1] * rise;
                let high = high[0] * rise + high[1] * after[l].minus(b[l]);
                self.along[l] = mix(self.t[l], low, high);
            }
            let [low, high] = with.across.map(|across| across.lean.map(|x| x as f32));
            if low != [0.0; 2] || high != [0.0; 2] {
                for l in 0..BATCH {
                    let slope = |[low, high]: &[[T; BATCH]; 2]| central(low[l], high[l]);
                    let low = low[0] * slope(&first[0]) + low[1] * slope(&second[0]);
                    let high = high[0] * slope(&first[1]) + high[1] * slope(&second[1]);
                    self.along[l] -= mix(self.t[l], low, high);
                }
            }
        } else {
            for l in 0..BATCH {
                let [[a_low, a_high], [b_low, b_high]] = second;
                let low = low[0] * a[l].minus(a_low[l]) + low[1] * a_high[l].minus(a[l]);
                let high = high[0] * b[l].minus(b_low[l]) + high[1] * b_high[l].minus(b[l]);
                self.second[l] = mix(self.t[l], low, high);
            }
            for l in 0..BATCH {
                self.along[l] = mix(self.t[l], central(before[l], b[l]), central(a[l], after[l]));
            }
        }
    }

    /// Turns slopes into directions of length 1.
    ///
    /// Where the field is resolved, a gradient does not lead against its edge, but for the little
    /// that it curves within a step. Features thinner than a step can have central differences that
    /// say just the opposite of the edge between them: there the slope along the edge is the edge's
    /// own.
    #[inline(always)]
    fn turn<const AXIS: usize>(&mut self, with: &Making) {
        let [i, j, k] = with.columns;
        let [own, first, second] = in_order::<AXIS>(with.squares);
        for l in 0..BATCH {
            let (u, v, rise) = (self.first[l], self.second[l], self.rise[l]);
            let along = self.along[l];
            let leans_back = along * 1f32.copysign(rise) < 0.0;
            let far = AGAINST * own * along * along > first * u * u + second * v * v;
            let along = if leans_back & far { rise } else { along };
            let [di, dj, dk] = match AXIS {
                0 => [along, u, v],
                1 => [u, along, v],
                _ => [u, v, along],
            };
            let x = i[0] * di + j[0] * dj + k[0] * dk;
            let y = i[1] * di + j[1] * dj + k[1] * dk;
            let z = i[2] * di + j[2] * dj + k[2] * dk;
            let square = x * x + y * y + z * z;
            let length = square.sqrt();
            // No negative zeroes, which look odd in text.
            self.x[l] = x / length + 0.0;
            self.y[l] = y / length + 0.0;
            self.z[l] = z / length + 0.0;
            self.square[l] = square;
        }
    }
}

/// Of numbers along i, j and k: that of the edges' own axis, then those of the other two.
fn in_order<const AXIS: usize>([i, j, k]: [f32; 3]) -> [f32; 3] {
    match AXIS {
        0 => [i, j, k],
        1 => [j, i, k],
        _ => [k, i, j],
    }
}

/// Squares of lengths that `f32` can tell: a length is made 1 in `f32`, whose roots and quotients take
/// a third of the time, and keeps six digits.
pub(in crate::kernel) const LEAST_SQUARE: f32 = 1e-30;
pub(in crate::kernel) const MOST_SQUARE: f32 = 1e30;

#[inline(always)]
fn usual(square: f32) -> bool {
    square > LEAST_SQUARE && square < MOST_SQUARE
}
