//! The gradient at a vertex from the samples around its edge.
//!
//! Edges that have all their neighbours are gathered, sample by sample, into arrays a neighbour,
//! which the compiler then works through in vectors. Edges at the border take the plain path.

use super::frame::{Across, Frame};
use crate::geom::vec3::Vec3;
use crate::kernel::vertices::Placing;
use crate::kernel::{Cpu, crossing, simd};
use crate::mesh::Normal;
use crate::volume::Sample;

/// Edges gathered before their normals are made.
const LANES: usize = 64;

/// A gradient leads against its edge where it leans back by more than this: the square of the
/// cotangent of 14 degrees.
const AGAINST: f64 = 16.0;

/// Factors of the differences to the sample before and to the one after, for each axis.
type Weights = [[f64; 2]; 3];

/// The samples of an edge from `a` to `b` and those around it.
///
/// ```text
/// 0 a   1 b   2 before a along the edge   3 after b
/// 4 5   a's neighbours along the first other axis, before and after;   6 7   b's
/// 8 9   a's neighbours along the second other axis;   10 11   b's
/// ```
type Star<S> = [S; 12];

/// What the normals of one plane's edges, or of the edges between two planes, are made of.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Around<'a, T> {
    pub(super) cpu: Cpu,
    pub(super) placing: &'a Placing,
    /// 1 where values rise from the iso value into the inside, else -1.
    pub(super) sign: f64,
    /// The planes before `a`, of `a`, after it, and the one after that; the last one there is where
    /// the volume ends before.
    pub(super) planes: [&'a [T]; 4],
    /// For the planes of `a` and of the one after.
    pub(super) across: [Across; 2],
    pub(super) frame: Frame,
    /// What the squares of slopes along i, j and k are multiplied by to be compared: 1 over the
    /// square of the step, up to a factor.
    pub(super) squares: [f64; 3],
}

/// Edges along one axis whose normals are still to be made.
#[derive(Debug)]
pub(in crate::kernel) struct Gathered<T> {
    n: usize,
    /// Where `a` is in its plane.
    places: [usize; LANES],
    /// Which normal it is.
    slots: [usize; LANES],
    samples: Star<[T; LANES]>,
}

impl<T: Sample> Gathered<T> {
    pub(super) fn new() -> Self {
        Self { n: 0, places: [0; LANES], slots: [0; LANES], samples: [[T::default(); LANES]; 12] }
    }

    /// Adds the edge from the sample at `place`, all of whose neighbours are there; it has the
    /// normal number `slot`.
    #[inline(always)]
    pub(super) fn add<const AXIS: usize>(
        &mut self,
        around: &Around<'_, T>,
        place: usize,
        slot: usize,
        out: &mut [Normal],
    ) {
        let n = self.n % LANES;
        self.places[n] = place;
        self.slots[n] = slot;
        for (lanes, sample) in self.samples.iter_mut().zip(around.star::<AXIS>(place)) {
            lanes[n] = sample;
        }
        self.n = n + 1;
        if self.n == LANES {
            self.flush::<AXIS>(around, out);
        }
    }

    /// Makes the normals of the edges gathered.
    pub(super) fn flush<const AXIS: usize>(&mut self, around: &Around<'_, T>, out: &mut [Normal]) {
        simd::normals::<T, AXIS>(around.cpu, around, self, out);
        self.n = 0;
    }

    /// Writes the normals of the edges gathered.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(in crate::kernel) fn make<const AXIS: usize>(
        &self,
        around: &Around<'_, T>,
        out: &mut [Normal],
    ) {
        let n = self.n.min(LANES);
        let frame = around.frame.times(-around.sign);
        let mut normals = [[0f32; LANES]; 3];
        let mut are_usual = [false; LANES];
        // Whole vectors; what the lanes beyond `n` hold is not looked at.
        let m = n.next_multiple_of(8).min(LANES);
        let samples = self.samples.each_ref().map(|lanes| &lanes[..m]);
        let [x, y, z] = normals.each_mut().map(|lanes| &mut lanes[..m]);
        let usual = &mut are_usual[..m];
        for l in 0..m {
            let star = samples.map(|lanes| lanes[l].to_f64());
            let normal = frame.turn(around.slopes::<AXIS, false>(star, &[[[0.0; 2]; 3]; 2]));
            let square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
            let by = 1.0 / square.sqrt();
            x[l] = (normal[0] * by) as f32 + 0.0;
            y[l] = (normal[1] * by) as f32 + 0.0;
            z[l] = (normal[2] * by) as f32 + 0.0;
            usual[l] = square > 1e-200 && square < 1e200;
        }
        for l in 0..n {
            let normal = if are_usual[l] {
                normals.map(|lanes| lanes[l])
            } else {
                around.single::<AXIS>(self.places[l])
            };
            if let Some(slot) = out.get_mut(self.slots[l]) {
                *slot = normal;
            }
        }
    }
}

impl<T: Sample> Around<'_, T> {
    /// The samples around the edge from `place`, all of which are there.
    #[inline(always)]
    fn star<const AXIS: usize>(&self, place: usize) -> Star<T> {
        let nx = self.placing.dims.0;
        let [before, plane, after, beyond] = self.planes;
        match AXIS {
            0 => {
                let [c, a, b, d] = run(plane, place - 1);
                let ([e, f], [g, h]) = (run(plane, place - nx), run(plane, place + nx));
                let ([p, q], [r, s]) = (run(before, place), run(after, place));
                [a, b, c, d, e, g, f, h, p, r, q, s]
            }
            1 => {
                let ([e, a, f], [g, b, h]) = (run(plane, place - 1), run(plane, place + nx - 1));
                let (c, d) = (plane[place - nx], plane[place + 2 * nx]);
                let (p, q) = (before[place], before[place + nx]);
                let (r, s) = (after[place], after[place + nx]);
                [a, b, c, d, e, f, g, h, p, r, q, s]
            }
            _ => {
                let ([e, a, f], [g, b, h]) = (run(plane, place - 1), run(after, place - 1));
                let (c, d) = (before[place], beyond[place]);
                let (p, q) = (plane[place - nx], plane[place + nx]);
                let (r, s) = (after[place - nx], after[place + nx]);
                [a, b, c, d, e, f, g, h, p, q, r, s]
            }
        }
    }

    /// The slopes along i, j and k at the vertex, `weights` those of the two ends along i and j
    /// where one of them is at the `BORDER`.
    ///
    /// Where the field is resolved, they do not lead against the edge, but for the little that it
    /// curves within a step. Features thinner than a step can have central differences that say just
    /// the opposite of the edge between them: there the slope along the edge is the edge's own.
    #[inline(always)]
    fn slopes<const AXIS: usize, const BORDER: bool>(
        &self,
        star: Star<f64>,
        weights: &[Weights; 2],
    ) -> Vec3 {
        let [a, b, before, after, ..] = star;
        let rise = b - a;
        let t = crossing(a, b, self.placing.level, self.placing.epsilon);
        let mix = |a: f64, b: f64| (1.0 - t) * a + t * b;
        let within = |axis: usize, end: usize, [low, middle, high]: [f64; 3]| {
            if BORDER {
                let [w, v] = weights[end][axis];
                w * (middle - low) + v * (high - middle)
            } else {
                0.5 * (high - low)
            }
        };
        let across = |end: usize, [low, middle, high]: [f64; 3]| {
            let [w, v] = self.across[end].weights;
            w * (middle - low) + v * (high - middle)
        };
        let (first, second) = others::<AXIS>();
        let (u, v) = ([star[4], a, star[5]], [star[8], a, star[9]]);
        let (p, q) = ([star[6], b, star[7]], [star[10], b, star[11]]);
        let (u, p) = (within(first, 0, u), within(first, 1, p));
        let (v, q) = if AXIS == 2 {
            (within(second, 0, v), within(second, 1, q))
        } else {
            (across(0, v), across(0, q))
        };
        let along = if AXIS == 2 {
            let [m, n] = [0, 1].map(|end| self.across[end].lean);
            let low = across(0, [before, a, b]) - m[0] * u - m[1] * v;
            let high = across(1, [a, b, after]) - n[0] * p - n[1] * q;
            mix(low, high)
        } else {
            mix(within(AXIS, 0, [before, a, b]), within(AXIS, 1, [a, b, after]))
        };
        let (u, v) = (mix(u, p), mix(v, q));
        let [m, n, o] = self.squares;
        let (m, n, o) = match AXIS {
            0 => (m, n, o),
            1 => (n, m, o),
            _ => (o, m, n),
        };
        let leans_back = along * 1f64.copysign(rise) < 0.0;
        // Where squares of such sizes can be taken; `single` is asked again where they cannot.
        let most = if BORDER { along.abs().max(u.abs()).max(v.abs()) } else { 1.0 };
        let [p, q, r] = [along, u, v].map(|x| if BORDER { x / most } else { x });
        let far = AGAINST * m * p * p > n * q * q + o * r * r;
        let along = if leans_back && far { rise } else { along };
        match AXIS {
            0 => [along, u, v],
            1 => [u, along, v],
            _ => [u, v, along],
        }
    }

    /// The normal at the vertex of the edge from `place`, wherever that is and whatever the samples
    /// are: where they make no gradient, the edge's own direction, from inside to outside.
    pub(super) fn single<const AXIS: usize>(&self, place: usize) -> Normal {
        let (nx, ny) = self.placing.dims;
        let a = [place % nx, place / nx, 1];
        let mut b = a;
        b[AXIS] += 1;
        let at = |[i, j, plane]: [usize; 3]| self.planes[plane][j * nx + i].to_f64();
        let last = [nx - 1, ny - 1, 3];
        let beside = |mut of: [usize; 3], axis: usize, is_after: bool| {
            let x = &mut of[axis];
            *x = if is_after { (*x + 1).min(last[axis]) } else { x.saturating_sub(1) };
            at(of)
        };
        let both = |of: [usize; 3], axis: usize| [beside(of, axis, false), beside(of, axis, true)];
        let (first, second) = others::<AXIS>();
        let ([e, f], [g, h]) = (both(a, first), both(b, first));
        let ([p, q], [r, s]) = (both(a, second), both(b, second));
        let (before, after) = (beside(a, AXIS, false), beside(b, AXIS, true));
        let star = [at(a), at(b), before, after, e, f, g, h, p, q, r, s];
        let weights = [a, b].map(|[i, j, _]| [at_border(i, nx), at_border(j, ny), [0.0; 2]]);
        let slopes = self.slopes::<AXIS, true>(star, &weights);
        let usual = self.frame.unit(slopes.map(|x| -self.sign * x));
        usual.unwrap_or_else(|| {
            let mut outward = [0.0; 3];
            outward[AXIS] = self.outward([at(a), at(b)]);
            self.direction(outward)
        })
    }

    /// 1 where the edge's upper sample is the one outside, else -1. NaN is outside; else two
    /// samples on different sides differ.
    fn outward(&self, [a, b]: [f64; 2]) -> f64 {
        if a.is_nan() {
            -1.0
        } else if b.is_nan() {
            1.0
        } else {
            let is_rising = b > a;
            if is_rising { -self.sign } else { self.sign }
        }
    }

    /// The unit vector that points as this one of the grid's axes does; for caps too.
    pub(super) fn direction(&self, outward: Vec3) -> Normal {
        self.frame.unit(outward).unwrap_or([0.0, 0.0, 1.0])
    }
}

/// The other two axes.
const fn others<const AXIS: usize>() -> (usize, usize) {
    match AXIS {
        0 => (1, 2),
        1 => (0, 2),
        _ => (0, 1),
    }
}

/// Some samples side by side.
#[inline(always)]
fn run<T: Copy, const N: usize>(plane: &[T], from: usize) -> [T; N] {
    let samples = &plane[from..from + N];
    std::array::from_fn(|n| samples[n])
}

/// Factors of the differences to the sample before and to the one after; one-sided at an end.
fn at_border(x: usize, n: usize) -> [f64; 2] {
    match (x == 0, x + 1 == n) {
        (false, false) => [0.5, 0.5],
        (true, false) => [0.0, 1.0],
        (false, true) => [1.0, 0.0],
        (true, true) => [0.0, 0.0],
    }
}
