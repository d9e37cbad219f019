//! The gradients of many edges side by side, as loops that a compiler makes vectors of.
//!
//! One step a loop, over arrays, without branches; the same bits whatever the width of vectors.

use super::frame::Across;
use crate::kernel::crossing;
use crate::mesh::Normal;
use crate::volume::Sample;

/// Edges worked on side by side.
pub(super) const LANES: usize = 64;

/// The samples of an edge from `a` to `b` and those around it.
///
/// ```text
/// 0 a   1 b   2 before a along the edge   3 after b
/// 4 5   a's neighbours along the first other axis, before and after;   6 7   b's
/// 8 9   a's neighbours along the second other axis;   10 11   b's
/// ```
pub(super) type Star<S> = [S; 12];

/// A gradient leads against its edge where it leans back by more than this: the square of the
/// cotangent of 14 degrees.
pub(in crate::kernel) const AGAINST: f64 = 16.0;

/// What the gradients of one family of edges are made with.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Making {
    pub(in crate::kernel) level: f64,
    pub(in crate::kernel) epsilon: f64,
    /// For the planes of `a` and of `b`.
    pub(in crate::kernel) across: [Across; 2],
    /// Outward directions of slopes along i, j and k.
    pub(in crate::kernel) columns: [[f64; 3]; 3],
    /// What the squares of slopes along i, j and k are multiplied by to be compared.
    pub(in crate::kernel) squares: [f64; 3],
}

/// Edges whose neighbours are all there, on their way from samples to normals.
pub(super) struct Lanes<T> {
    pub(super) samples: Star<[T; LANES]>,
    t: [f64; LANES],
    /// b - a.
    rise: [f64; LANES],
    along: [f64; LANES],
    /// Along the other two axes.
    first: [f64; LANES],
    second: [f64; LANES],
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    /// The squares of lengths before they were made 1.
    square: [f64; LANES],
}

/// From the lower end's slope to the upper one's.
#[inline(always)]
pub(super) fn mix(t: f64, a: f64, b: f64) -> f64 {
    (1.0 - t) * a + t * b
}

impl<T: Sample> Lanes<T> {
    pub(super) fn new() -> Self {
        let (none, small) = ([0.0; LANES], [0.0; LANES]);
        Self {
            samples: [[T::default(); LANES]; 12],
            t: none,
            rise: none,
            along: none,
            first: none,
            second: none,
            x: small,
            y: small,
            z: small,
            square: none,
        }
    }

    /// Makes normals of the samples.
    #[inline(always)]
    pub(super) fn make<const AXIS: usize>(&mut self, with: &Making) {
        self.place(with);
        self.slopes::<AXIS>(with);
        self.turn::<AXIS>(with);
    }

    /// The normal of a lane, of length 1 if [`Lanes::is_usual`].
    #[inline(always)]
    pub(super) fn normal(&self, l: usize) -> Normal {
        [self.x[l], self.y[l], self.z[l]]
    }

    /// Whether the squares could be taken: not of zero, not of numbers too large or too small.
    #[inline(always)]
    pub(super) fn is_usual(&self, l: usize) -> bool {
        usual(self.square[l])
    }

    /// Whether that holds for the first `n` lanes.
    #[inline(always)]
    pub(super) fn all_usual(&self, n: usize) -> bool {
        self.square[..n.min(LANES)].iter().fold(true, |all, &square| all & usual(square))
    }

    /// The vertices' own places on their edges.
    #[inline(always)]
    fn place(&mut self, with: &Making) {
        let [a, b, ..] = &self.samples;
        for l in 0..LANES {
            let (a, b) = (a[l].to_f64(), b[l].to_f64());
            self.rise[l] = b - a;
            self.t[l] = crossing(a, b, with.level, with.epsilon);
        }
    }

    #[inline(always)]
    fn slopes<const AXIS: usize>(&mut self, with: &Making) {
        let [a, b, before, after, p, q, r, s, v, w, x, y] = &self.samples;
        let central = |low: T, high: T| 0.5 * (high.to_f64() - low.to_f64());
        let [low, high] = with.across.map(|across| across.weights);
        for l in 0..LANES {
            self.first[l] = mix(self.t[l], central(p[l], q[l]), central(r[l], s[l]));
        }
        if AXIS == 2 {
            for l in 0..LANES {
                self.second[l] = mix(self.t[l], central(v[l], w[l]), central(x[l], y[l]));
            }
            for l in 0..LANES {
                let (a, b) = (a[l].to_f64(), b[l].to_f64());
                let (before, after) = (before[l].to_f64(), after[l].to_f64());
                let low = low[0] * (a - before) + low[1] * (b - a);
                let high = high[0] * (b - a) + high[1] * (after - b);
                self.along[l] = mix(self.t[l], low, high);
            }
            let [low, high] = with.across.map(|across| across.lean);
            if low != [0.0; 2] || high != [0.0; 2] {
                for l in 0..LANES {
                    let low = low[0] * central(p[l], q[l]) + low[1] * central(v[l], w[l]);
                    let high = high[0] * central(r[l], s[l]) + high[1] * central(x[l], y[l]);
                    self.along[l] -= mix(self.t[l], low, high);
                }
            }
        } else {
            for l in 0..LANES {
                let (a, b) = (a[l].to_f64(), b[l].to_f64());
                let low = low[0] * (a - v[l].to_f64()) + low[1] * (w[l].to_f64() - a);
                let high = high[0] * (b - x[l].to_f64()) + high[1] * (y[l].to_f64() - b);
                self.second[l] = mix(self.t[l], low, high);
            }
            for l in 0..LANES {
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
        for l in 0..LANES {
            let (u, v, rise) = (self.first[l], self.second[l], self.rise[l]);
            let along = self.along[l];
            let leans_back = along * 1f64.copysign(rise) < 0.0;
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
            let by = 1.0 / square.sqrt();
            // No negative zeroes, which look odd in text.
            self.x[l] = (x * by) as f32 + 0.0;
            self.y[l] = (y * by) as f32 + 0.0;
            self.z[l] = (z * by) as f32 + 0.0;
            self.square[l] = square;
        }
    }
}

/// Of numbers along i, j and k: that of the edges' own axis, then those of the other two.
fn in_order<const AXIS: usize>([i, j, k]: [f64; 3]) -> [f64; 3] {
    match AXIS {
        0 => [i, j, k],
        1 => [j, i, k],
        _ => [k, i, j],
    }
}

#[inline(always)]
fn usual(square: f64) -> bool {
    square > 1e-200 && square < 1e200
}
