//! A family of edges: all along one axis, of one plane or between two.

use super::crossing;
use super::gather::Gathered;
use super::vertices::{Placing, Plane};
use crate::geom::vec3::Vec3;
use crate::mesh::Position;
use crate::volume::Sample;

/// What places the vertices of a family. Edges are named by place `c` and row `r`, which count from
/// the border along the family's own axis: there the edge 0 comes out of the border.
#[derive(Clone, Copy)]
pub(super) struct Family<'a, T> {
    /// The samples at either end, both under the index of the lower one.
    pub(super) ends: [&'a [T]; 2],
    /// Samples from the index of an edge back to its lower end.
    pub(super) back: usize,
    /// The same along i and j.
    pub(super) back_ij: [f64; 2],
    /// The places (and rows) of the edges out of the border and into it; `NONE` where there are
    /// none.
    pub(super) border_c: [u32; 2],
    pub(super) border_r: [u32; 2],
    /// All edges come out of the border, or go into it.
    pub(super) cap: [bool; 2],
    pub(super) nx: usize,
    pub(super) level: f64,
    pub(super) epsilon: f64,
    pub(super) origin: Vec3,
    pub(super) step_i: Vec3,
    pub(super) step_j: Vec3,
    /// Along the edges.
    pub(super) step: Vec3,
}

/// No place and no row.
const NONE: u32 = u32::MAX;

impl<'a, T: Sample> Family<'a, T> {
    /// The X edges of a plane.
    pub(super) fn x(placing: &Placing, plane: &Plane<'a, T>) -> Self {
        let ends = [plane.samples, plane.samples.get(1..).unwrap_or_default()];
        let border_c = [0, placing.dims.0 as u32];
        let all = Self::new(placing, ends, plane.origin, placing.step_i);
        Self { back: 1, back_ij: [1.0, 0.0], border_c, ..all }
    }

    /// The Y edges of a plane.
    pub(super) fn y(placing: &Placing, plane: &Plane<'a, T>) -> Self {
        let (nx, ny) = placing.dims;
        let ends = [plane.samples, plane.samples.get(nx..).unwrap_or_default()];
        let all = Self::new(placing, ends, plane.origin, placing.step_j);
        Self { back: nx, back_ij: [0.0, 1.0], border_r: [0, ny as u32], ..all }
    }

    /// The Z edges from one plane to the next, one `step` on.
    pub(super) fn z(placing: &Placing, planes: [&Plane<'a, T>; 2], step: Vec3) -> Self {
        let ends = planes.map(|plane| plane.samples);
        let cap = ends.map(<[T]>::is_empty);
        Self { cap, ..Self::new(placing, ends, planes[0].origin, step) }
    }

    fn new(placing: &Placing, ends: [&'a [T]; 2], origin: Vec3, step: Vec3) -> Self {
        Self {
            ends,
            back: 0,
            back_ij: [0.0; 2],
            border_c: [NONE; 2],
            border_r: [NONE; 2],
            cap: [false; 2],
            nx: placing.dims.0,
            level: placing.level,
            epsilon: placing.epsilon,
            origin,
            step_i: placing.step_i,
            step_j: placing.step_j,
            step,
        }
    }

    /// The axis along which the edges run.
    pub(super) fn axis(&self) -> usize {
        if self.back == 0 { 2 } else { usize::from(self.back_ij[1] > 0.0) }
    }

    /// The values at the ends of an edge; anything where one lies in the border.
    #[inline(always)]
    pub(super) fn values(&self, c: u32, r: u32) -> [f64; 2] {
        let at = (r as usize * self.nx + c as usize).wrapping_sub(self.back);
        self.ends.map(|samples| samples.get(at).copied().unwrap_or_default().to_f64())
    }

    /// The vertex on an edge: the definition.
    #[inline(always)]
    pub(super) fn vertex(&self, c: u32, r: u32) -> Position {
        let t = if self.cap[0] || c == self.border_c[0] || r == self.border_r[0] {
            1.0 - self.epsilon
        } else if self.cap[1] || c == self.border_c[1] || r == self.border_r[1] {
            self.epsilon
        } else {
            let [a, b] = self.values(c, r);
            crossing(a, b, self.level, self.epsilon)
        };
        let (i, j) = (f64::from(c) - self.back_ij[0], f64::from(r) - self.back_ij[1]);
        let along = |axis: usize| {
            let sample = (self.origin[axis] + j * self.step_j[axis]) + i * self.step_i[axis];
            (sample + t * self.step[axis]) as f32
        };
        [along(0), along(1), along(2)]
    }

    /// The vertices on gathered edges.
    #[inline(always)]
    pub(super) fn place(&self, gathered: &Gathered, out: &mut [Position]) {
        for ((c, r), slot) in gathered.iter().zip(out) {
            *slot = self.vertex(c, r);
        }
    }
}
