//! The samples around the edges of a plane, or between two planes, and the normals they give.

use super::batch::{AGAINST, BATCH, Batch, Making, Star};
use super::frame::Frame;
use crate::geom::vec3::{Vec3, dot};
use crate::kernel::crossing;
use crate::kernel::gather::Gathered;
use crate::mesh::Normal;
use crate::volume::Sample;

/// What the normals of one plane's edges, or of the edges between two planes, are made of.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Around<'a, T> {
    /// The planes before `a`, of `a`, after it, and the one after that; the last one there is where
    /// the volume ends before.
    pub(in crate::kernel) planes: [&'a [T]; 4],
    pub(in crate::kernel) dims: (usize, usize),
    /// 1 where values rise from the iso value into the inside, else -1.
    pub(super) sign: f64,
    pub(super) frame: Frame,
    /// The directions of the caps before and after all samples along i, and along j.
    pub(super) caps: [[Normal; 2]; 2],
    pub(in crate::kernel) making: Making,
}

impl<T: Sample> Around<'_, T> {
    /// The normals of the vertices on gathered edges.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(in crate::kernel) fn normals<const AXIS: usize>(
        &self,
        edges: &Gathered,
        out: &mut [Normal],
    ) {
        let mut batch = Batch::new();
        let mut edges = edges.iter();
        let [columns, rows] = self.within::<AXIS>();
        for out in out.chunks_mut(BATCH) {
            // Edges that have all their neighbours, and their slots in `out`.
            let (mut places, mut slots, mut n) = ([0; BATCH], [0; BATCH], 0);
            for (slot, (c, r)) in edges.by_ref().take(out.len()).enumerate() {
                if columns.holds(c) & rows.holds(r) {
                    (places[n % BATCH], slots[n % BATCH]) = (self.lower_end::<AXIS>(c, r), slot);
                    n += 1;
                } else {
                    out[slot] = self.one::<AXIS>(c, r);
                }
            }
            let (places, slots) = (&places[..n.min(BATCH)], &slots[..n.min(BATCH)]);
            if n == 0 {
                continue;
            }
            self.gather::<AXIS>(places, &mut batch.samples);
            batch.make::<AXIS>(&self.making);
            for (l, &slot) in slots.iter().enumerate() {
                out[slot] = batch.normal(l % BATCH);
            }
            if !batch.all_usual(n) {
                for (l, (&slot, &place)) in slots.iter().zip(places).enumerate() {
                    if !batch.is_usual(l % BATCH) {
                        out[slot] = self.single::<AXIS>(place);
                    }
                }
            }
        }
    }

    /// Where edges have all their neighbours, by place and row. Those are counted from the border
    /// along the edges' own axis, as the families of edges do.
    pub(in crate::kernel) fn within<const AXIS: usize>(&self) -> [Within; 2] {
        let (nx, ny) = self.dims;
        [Within::of(nx, AXIS == 0), Within::of(ny, AXIS == 1)]
    }

    /// The sample at the lower end of an edge that does not come out of the border.
    #[inline(always)]
    fn lower_end<const AXIS: usize>(&self, c: u32, r: u32) -> usize {
        let nx = self.dims.0;
        let back = [1, nx, 0][AXIS];
        r as usize * nx + c as usize - back
    }

    /// The samples around the edges from `places`, all of which are there.
    ///
    /// Plane by plane, those first that nobody has looked at yet: short loops keep many loads from
    /// memory under way.
    #[inline(always)]
    fn gather<const AXIS: usize>(&self, places: &[usize], star: &mut Star<[T; BATCH]>) {
        let nx = self.dims.0;
        let [before, plane, after, beyond] = self.planes;
        let Star { a, b, outer: [outer_a, outer_b], first, second } = star;
        let ([[a1, a2], [b1, b2]], [[a3, a4], [b3, b4]]) = (first, second);
        let each = || places.iter().copied().take(BATCH).enumerate();
        match AXIS {
            0 => {
                each().for_each(|(l, at)| [a4[l], b4[l]] = run(after, at));
                each().for_each(|(l, at)| [a3[l], b3[l]] = run(before, at));
                each().for_each(|(l, at)| {
                    [outer_a[l], a[l], b[l], outer_b[l]] = run(plane, at - 1);
                });
                each().for_each(|(l, at)| [a1[l], b1[l]] = run(plane, at - nx));
                each().for_each(|(l, at)| [a2[l], b2[l]] = run(plane, at + nx));
            }
            1 => {
                each().for_each(|(l, at)| [a4[l], b4[l]] = [after[at], after[at + nx]]);
                each().for_each(|(l, at)| [a3[l], b3[l]] = [before[at], before[at + nx]]);
                each().for_each(|(l, at)| [a1[l], a[l], a2[l]] = run(plane, at - 1));
                each().for_each(|(l, at)| [b1[l], b[l], b2[l]] = run(plane, at + nx - 1));
                each().for_each(|(l, at)| {
                    [outer_a[l], outer_b[l]] = [plane[at - nx], plane[at + 2 * nx]];
                });
            }
            _ => {
                each().for_each(|(l, at)| outer_b[l] = beyond[at]);
                each().for_each(|(l, at)| outer_a[l] = before[at]);
                each().for_each(|(l, at)| [b1[l], b[l], b2[l]] = run(after, at - 1));
                each().for_each(|(l, at)| [b3[l], b4[l]] = [after[at - nx], after[at + nx]]);
                each().for_each(|(l, at)| [a1[l], a[l], a2[l]] = run(plane, at - 1));
                each().for_each(|(l, at)| [a3[l], a4[l]] = [plane[at - nx], plane[at + nx]]);
            }
        }
    }

    /// The normal at the vertex of any one edge: at the border, into it, or within.
    #[cold]
    pub(in crate::kernel) fn one<const AXIS: usize>(&self, c: u32, r: u32) -> Normal {
        let (nx, ny) = self.dims;
        let (at, n) = ([c, r, 1][AXIS] as usize, [nx, ny, 2][AXIS]);
        if at == 0 || at == n {
            return self.caps[AXIS % 2][usize::from(at > 0)];
        }
        self.single::<AXIS>(self.lower_end::<AXIS>(c, r))
    }

    /// The normal at the vertex of the edge from the sample at `place`.
    #[cold]
    fn single<const AXIS: usize>(&self, place: usize) -> Normal {
        let nx = self.dims.0;
        let a = [place % nx, place / nx, 1];
        let mut b = a;
        b[AXIS] += 1;
        self.on_edge(a, b)
    }

    /// The normal at the vertex between two samples of one cell, wherever they are and whatever the
    /// samples: where they make no gradient, the direction from the inside one to the outside one.
    /// Samples as (i, j, plane), plane 1 that of `a`.
    pub(in crate::kernel) fn on_edge(&self, a: [usize; 3], b: [usize; 3]) -> Normal {
        let [low, high] = [self.slopes(a, 0), self.slopes(b, 1)];
        let edge = [0, 1, 2].map(|axis| (b[axis] - a[axis]) as f64);
        let (a, b) = (self.at(a), self.at(b));
        let t = crossing(a, b, self.making.level, self.making.epsilon);
        let slopes = [0, 1, 2].map(|axis| (1.0 - t) * low[axis] + t * high[axis]);
        let slopes = self.outward_along(edge, slopes, b - a);
        let usual = self.frame.unit(slopes.map(|x| -self.sign * x));
        usual.unwrap_or_else(|| self.frame.direction(edge.map(|x| x * self.outward([a, b]))))
    }

    fn at(&self, [i, j, plane]: [usize; 3]) -> f64 {
        self.planes[plane][j * self.dims.0 + i].to_f64()
    }

    /// The slopes along i, j and k at a sample, one-sided at the border; `end` as in
    /// [`Making::across`].
    fn slopes(&self, of: [usize; 3], end: usize) -> Vec3 {
        let (nx, ny) = self.dims;
        let across = &self.making.across[end];
        let weights = [one_sided(of[0], nx), one_sided(of[1], ny), across.weights];
        let last = [nx - 1, ny - 1, 3];
        let [i, j, k] = [0, 1, 2].map(|axis| {
            let (mut low, mut high) = (of, of);
            low[axis] = of[axis].saturating_sub(1);
            high[axis] = (of[axis] + 1).min(last[axis]);
            let ([low, middle, high], [v, w]) =
                ([low, of, high].map(|p| self.at(p)), weights[axis]);
            v * (middle - low) + w * (high - middle)
        });
        let [m, n] = across.lean;
        [i, j, k - (m * i + n * j)]
    }

    /// Slopes that do not lead against the edge, for the same reason as in [`Batch`] and, along the
    /// grid's axes, by the same measure.
    fn outward_along(&self, edge: Vec3, slopes: Vec3, rise: f64) -> Vec3 {
        let most = slopes.iter().fold(0f64, |most, x| most.max(x.abs()));
        let scaled = slopes.map(|x| x / most);
        let squares = self.making.squares.map(f64::from);
        // The edge's share of the square of its length, along each axis.
        let parts = [0, 1, 2].map(|axis| edge[axis] / squares[axis]);
        let length = dot(parts, edge);
        let along = dot(scaled, edge);
        let all: f64 = (0..3).map(|axis| squares[axis] * scaled[axis] * scaled[axis]).sum();
        let leans_back = along * 1f64.copysign(rise) < 0.0;
        if leans_back && f64::from(AGAINST + 1.0) * along * along > length * all {
            let missing = rise - dot(slopes, edge);
            [0, 1, 2].map(|axis| slopes[axis] + missing * parts[axis] / length)
        } else {
            slopes
        }
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
}

/// From the first number to behind the last.
#[derive(Clone, Copy)]
pub(in crate::kernel) struct Within {
    pub(in crate::kernel) first: u32,
    pub(in crate::kernel) n: u32,
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
fn one_sided(x: usize, n: usize) -> [f64; 2] {
    match (x == 0, x + 1 == n) {
        (false, false) => [0.5, 0.5],
        (true, false) => [0.0, 1.0],
        (false, true) => [1.0, 0.0],
        (true, true) => [0.0, 0.0],
    }
}
