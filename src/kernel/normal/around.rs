//! The samples around the edges of a plane, or between two planes, and the normals they give.

use super::frame::Frame;
use super::lanes::{AGAINST, LANES, Lanes, Making, Star, in_order, mix};
use crate::geom::vec3::Vec3;
use crate::kernel::crossing;
use crate::kernel::gather::Gathered;
use crate::mesh::Normal;
use crate::volume::Sample;

/// What the normals of one plane's edges, or of the edges between two planes, are made of.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Around<'a, T> {
    /// The planes before `a`, of `a`, after it, and the one after that; the last one there is where
    /// the volume ends before.
    pub(super) planes: [&'a [T]; 4],
    pub(super) dims: (usize, usize),
    /// 1 where values rise from the iso value into the inside, else -1.
    pub(super) sign: f64,
    pub(super) frame: Frame,
    pub(super) making: Making,
}

/// Factors of the differences to the sample before and to the one after, for each axis.
type Weights = [[f64; 2]; 3];

impl<T: Sample> Around<'_, T> {
    /// The normals of the vertices on gathered edges.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(super) fn normals<const AXIS: usize>(&self, edges: &Gathered, out: &mut [Normal]) {
        let mut lanes = Lanes::new();
        let mut places = edges.iter();
        let [columns, rows] = self.within::<AXIS>();
        for out in out.chunks_mut(LANES) {
            let mut apart = 0u64;
            let chunk = places.clone();
            for (l, (c, r)) in places.by_ref().take(out.len()).enumerate() {
                if columns.holds(c) & rows.holds(r) {
                    let place = self.place::<AXIS>(c, r);
                    for (lanes, sample) in lanes.samples.iter_mut().zip(self.star::<AXIS>(place)) {
                        lanes[l % LANES] = sample;
                    }
                } else {
                    apart |= 1 << (l % LANES);
                }
            }
            lanes.make::<AXIS>(&self.making);
            for (l, normal) in out.iter_mut().enumerate() {
                *normal = lanes.normal(l % LANES);
            }
            if apart != 0 || !lanes.all_usual(out.len()) {
                for ((l, normal), (c, r)) in out.iter_mut().enumerate().zip(chunk) {
                    if apart >> (l % LANES) & 1 == 1 || !lanes.is_usual(l % LANES) {
                        *normal = self.single::<AXIS>(c, r);
                    }
                }
            }
        }
    }

    /// Where edges have all their neighbours, by place and row. Those are counted from the border
    /// along the edges' own axis, as the families of edges do.
    fn within<const AXIS: usize>(&self) -> [Within; 2] {
        let (nx, ny) = self.dims;
        [Within::of(nx, AXIS == 0), Within::of(ny, AXIS == 1)]
    }

    /// The sample at the lower end of an edge that does not come out of the border.
    #[inline(always)]
    fn place<const AXIS: usize>(&self, c: u32, r: u32) -> usize {
        let nx = self.dims.0;
        let back = [1, nx, 0][AXIS];
        r as usize * nx + c as usize - back
    }

    /// The samples around the edge from `place`, all of which are there.
    #[inline(always)]
    fn star<const AXIS: usize>(&self, place: usize) -> Star<T> {
        let nx = self.dims.0;
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

    /// The normal at the vertex of an edge, wherever that is and whatever the samples are: where
    /// they make no gradient, the edge's own direction, from inside to outside.
    fn single<const AXIS: usize>(&self, c: u32, r: u32) -> Normal {
        let (nx, ny) = self.dims;
        let (at, n) = ([c, r, 1][AXIS] as usize, [nx, ny, 2][AXIS]);
        let mut outward = [0.0; 3];
        if at == 0 || at == n {
            outward[AXIS] = if at == 0 { -1.0 } else { 1.0 };
            return self.direction(outward);
        }
        let a = {
            let place = self.place::<AXIS>(c, r);
            [place % nx, place / nx, 1]
        };
        let mut b = a;
        b[AXIS] += 1;
        let at = |[i, j, plane]: [usize; 3]| self.planes[plane][j * nx + i].to_f64();
        let last = [nx - 1, ny - 1, 3];
        let both = |of: [usize; 3], axis: usize| {
            let (mut low, mut high) = (of, of);
            low[axis] = of[axis].saturating_sub(1);
            high[axis] = (of[axis] + 1).min(last[axis]);
            [at(low), at(of), at(high)]
        };
        let gradient = |of: [usize; 3], end: usize| {
            let weights: Weights =
                [at_border(of[0], nx), at_border(of[1], ny), self.making.across[end].weights];
            [0, 1, 2].map(|axis| {
                let ([low, middle, high], [v, w]) = (both(of, axis), weights[axis]);
                v * (middle - low) + w * (high - middle)
            })
        };
        let [low, high] =
            [(a, 0), (b, 1)].map(|(of, end)| self.upright::<AXIS>(gradient(of, end), end));
        let (a, b) = (at(a), at(b));
        let t = crossing(a, b, self.making.level, self.making.epsilon);
        let slopes = [0, 1, 2].map(|axis| mix(t, low[axis], high[axis]));
        let slopes = self.outward_along::<AXIS>(slopes, b - a);
        self.frame.unit(slopes.map(|x| -self.sign * x)).unwrap_or_else(|| {
            outward[AXIS] = self.outward([a, b]);
            self.direction(outward)
        })
    }

    /// Between planes, takes off what the slope across has in it of those along i and j.
    fn upright<const AXIS: usize>(&self, slopes: Vec3, end: usize) -> Vec3 {
        let [m, n] = self.making.across[end].lean;
        let [i, j, k] = slopes;
        if AXIS == 2 { [i, j, k - (m * i + n * j)] } else { slopes }
    }

    /// The slope along the edge replaced by the edge's own where the gradient leads against it, as
    /// [`Lanes`] does.
    fn outward_along<const AXIS: usize>(&self, slopes: Vec3, rise: f64) -> Vec3 {
        let most = slopes.iter().fold(0f64, |most, x| most.max(x.abs()));
        let [along, u, v] = in_order::<AXIS>(slopes.map(|x| x / most));
        let [own, first, second] = in_order::<AXIS>(self.making.squares);
        let leans_back = along * 1f64.copysign(rise) < 0.0;
        let mut slopes = slopes;
        if leans_back && AGAINST * own * along * along > first * u * u + second * v * v {
            slopes[AXIS] = rise;
        }
        slopes
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

    /// The unit vector that stands for this direction along the grid's axes.
    fn direction(&self, outward: Vec3) -> Normal {
        self.frame.unit(outward).unwrap_or(super::UPWARD)
    }
}

/// From the first number to behind the last.
#[derive(Clone, Copy)]
struct Within {
    first: u32,
    n: u32,
}

impl Within {
    /// Of `n` samples, those that have both neighbours; of edges along them, those whose ends have.
    fn of(n: usize, is_own: bool) -> Self {
        if is_own {
            Self { first: 2, n: n.saturating_sub(3) as u32 }
        } else {
            Self { first: 1, n: n.saturating_sub(2) as u32 }
        }
    }

    #[inline(always)]
    fn holds(self, x: u32) -> bool {
        x.wrapping_sub(self.first) < self.n
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
