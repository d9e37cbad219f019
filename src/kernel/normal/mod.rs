//! A unit normal for each vertex, pointing from inside to outside.
//!
//! ```text
//! on a grid edge   the field's gradient at the edge's two samples (central differences, one-sided
//!                  at the border), interpolated as the vertex is
//! in a cell        the gradient of the cell's trilinear interpolant
//! on a cap         the cap's own direction
//! ```
//!
//! turned into output space by the inverse transpose of the map. Where on its edge a vertex lies is
//! found in `f64`, as for its position; gradients are worked out in `f32`, whose six digits are more
//! than any shading shows, twice as many at a time. All in one order, the same on every processor.

mod around;
mod batch;
mod frame;

pub(super) use around::{Around, Within};
pub(super) use batch::{AGAINST, LEAST_SQUARE, MOST_SQUARE, Making, Star};
use frame::{Across, Frame};

use super::decide::gradient;
use super::family::Family;
use super::gather::Gathered;
use super::slab::LayerScratch;
use super::tables::cube::edge_corners;
use super::vertices::Slots;
use super::{CellSurface, Classify, Kernel, Row, Slab, crossing};
use crate::geom::vec3::{Vec3, cross, norm, sub};
use crate::mesh::Normal;
use crate::volume::Sample;

/// What the normals of a layer are made of: those on the edges between its planes, and on the edges
/// of the plane after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings<'a, T> {
    /// Nothing where one plane is the border's.
    pub(super) between: Option<Around<'a, T>>,
    /// Nothing where the plane after is.
    pub(super) plane: Option<Around<'a, T>>,
    /// The direction of the Z edges' cap.
    pub(super) z_cap: Normal,
    frame: Frame,
}

impl<T: Sample> Surroundings<'_, T> {
    /// The unit vector that stands for a cap's outward direction along the grid's axes.
    pub(super) fn cap(&self, outward: Vec3) -> Normal {
        self.frame.direction(outward)
    }

    /// The planes that are looked at besides those whose edges have the vertices.
    pub(super) fn outer_planes(&self) -> [&[T]; 2] {
        let either = self.between.as_ref().or(self.plane.as_ref());
        either.map_or([&[]; 2], |&Around { planes: [before, .., beyond], .. }| [before, beyond])
    }

    /// The vertices on gathered edges of one family, with their normals.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(super) fn vertices(&self, family: &Family<'_, T>, edges: &Gathered, out: Slots<'_>) {
        family.place(edges, out.positions);
        let normals = out.normals.unwrap_or_default();
        match (family.axis(), &self.plane, &self.between) {
            (0, Some(plane), _) => plane.normals::<0>(edges, normals),
            (1, Some(plane), _) => plane.normals::<1>(edges, normals),
            (2, _, Some(between)) => between.normals::<2>(edges, normals),
            _ => normals.fill(self.z_cap),
        }
    }
}

impl<T: Classify> Kernel<T> {
    /// What surrounds the edges of layer `s`.
    pub(super) fn surroundings<'a>(&self, s: usize, slab: &Slab<'a, T>) -> Surroundings<'a, T> {
        let before = s.checked_sub(1);
        let ends = [before.and_then(|k| slab.plane(k)), slab.plane(s)];
        let frame = self.frame(self.place.step_k(s as i64 - 1));
        let outward = if ends[1].is_some() { -1.0 } else { 1.0 };
        Surroundings {
            between: match (before, ends) {
                (Some(k), [Some(a), Some(b)]) => Some(self.around(slab, k, [a, b], true)),
                _ => None,
            },
            plane: ends[1].map(|samples| self.around(slab, s, [samples; 2], false)),
            z_cap: frame.direction([0.0, 0.0, outward]),
            frame,
        }
    }

    /// The surroundings of edges that begin on plane `k`: those to the next plane, or those on it.
    fn around<'a>(
        &self,
        slab: &Slab<'a, T>,
        k: usize,
        [a, b]: [&'a [T]; 2],
        between: bool,
    ) -> Around<'a, T> {
        let before = k.checked_sub(1).and_then(|k| slab.plane(k)).unwrap_or(a);
        let at = |k: usize| slab.plane(k).unwrap_or(b);
        let (place, nz, low) = (&self.place, self.dims.nz(), k as i64);
        let (across, step) = if between {
            let step = place.step_k(low);
            ([low, low + 1].map(|k| Across::along(place, k, nz, step)), step)
        } else {
            let (across, step) = Across::at(place, low, nz);
            ([across; 2], step)
        };
        let frame = self.frame(step);
        let making = Making {
            level: self.placing.level,
            epsilon: self.placing.epsilon,
            across,
            columns: frame.times(-self.sign).map(|column| column.map(|x| x as f32)),
            squares: inverse_squares([self.placing.step_i, self.placing.step_j, step]),
        };
        let planes = [before, a, at(k + 1), at(k + if between { 2 } else { 1 })];
        let caps = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
            .map(|after: Vec3| [after.map(|x| -x), after].map(|outward| frame.direction(outward)));
        Around { planes, dims: self.placing.dims, sign: self.sign, frame, caps, making }
    }

    fn frame(&self, step_k: Vec3) -> Frame {
        Frame::new([self.placing.step_i, self.placing.step_j, step_k])
    }

    /// The normals of the vertices inside the cells of layer `s`. The cells are settled once more:
    /// they are few, and only those with such vertices.
    pub(super) fn extra_normals(
        &self,
        s: usize,
        slab: &Slab<'_, T>,
        layer: &LayerScratch,
        out: &mut [Normal],
    ) {
        let samples = [s.checked_sub(1).and_then(|k| slab.plane(k)), slab.plane(s)];
        let frame = self.frame(self.place.step_k(s as i64 - 1));
        let mut out = out.iter_mut();
        let mut unsettled = layer.cells.unsettled.iter().zip(&layer.settled.cells);
        for run in &layer.cells.rows {
            for (cell, settled) in unsettled.by_ref().take(run.n_unsettled as usize) {
                if settled.n_extra == 0 {
                    continue;
                }
                let corners = self.corners(samples, run.row as usize, cell.c as usize);
                let surface = self.settle_cell(cell.case, &corners);
                let values = corners.map(|sample| self.sign * (sample - self.placing.level));
                for n in 0..usize::from(surface.n_extra) {
                    let inward = gradient(&values, surface.extra[n]);
                    let usual = frame.unit(inward.map(|x| -x));
                    let normal = usual
                        .unwrap_or_else(|| frame.direction(self.facing(&surface, n, &corners)));
                    if let Some(slot) = out.next() {
                        *slot = normal;
                    }
                }
            }
        }
    }

    /// Where the gradient vanishes inside a cell: the outward direction of the first triangle at
    /// the vertex `n` there, along the grid's axes.
    fn facing(&self, surface: &CellSurface, n: usize, corners: &[f64; 8]) -> Vec3 {
        let row: &Row = &self.tables.rows[usize::from(surface.row)];
        let own = if row.n_centres > 0 { 15 } else { 12 + n as u8 };
        let Some(triangle) = row.triangles().find(|triangle| triangle.contains(&own)) else {
            return [0.0; 3];
        };
        let (level, epsilon) = (self.placing.level, self.placing.epsilon);
        let t = |edge: usize| {
            let [low, high] = edge_corners(edge);
            crossing(corners[low], corners[high], level, epsilon)
        };
        let [a, b, c] = triangle.map(|id| surface.point(id, t));
        let normal = cross(sub(b, a), sub(c, a));
        // The tables' winding is that of the output space.
        if self.place.is_reversed() { normal.map(|x| -x) } else { normal }
    }
}

/// 1 over the squares of lengths, the largest of them 1.
fn inverse_squares(steps: [Vec3; 3]) -> [f32; 3] {
    let lengths = steps.map(norm);
    let least = lengths.iter().fold(f64::INFINITY, |least, &length| least.min(length));
    lengths.map(|length| ((least / length) * (least / length)) as f32)
}
