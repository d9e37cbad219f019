//! Vertices on diagonals: as on grid edges, from the lower sample to the upper one.

use super::super::crossing;
use super::super::region::Region;
use super::super::vertices::{Placing, Plane};
use super::edges::{Crossings, Kind};
use crate::geom::vec3::{Vec3, add, scale};
use crate::mesh::Position;
use crate::volume::Sample;

/// `p + s · v`, rounded to output coordinates.
#[inline(always)]
fn along(p: Vec3, v: Vec3, s: f64) -> Position {
    [(p[0] + s * v[0]) as f32, (p[1] + s * v[1]) as f32, (p[2] + s * v[2]) as f32]
}

/// The crossed diagonals whose upper ends lie in one row.
pub(super) struct CrossedRow<'a> {
    region: Region,
    kind: Kind,
    /// The rows of bits of the lower and the upper ends.
    low: &'a [u64],
    high: &'a [u64],
}

impl CrossedRow<'_> {
    /// Calls `f` with the place of each upper end in its row, rising.
    #[inline(always)]
    pub(super) fn for_each(&self, mut f: impl FnMut(usize)) {
        for w in 0..self.high.len() - 1 {
            let mut word = self.kind.crossed(self.region, self.low, self.high, w);
            while word != 0 {
                f(64 * w + word.trailing_zeros() as usize);
                word &= word - 1;
            }
        }
    }
}

/// Diagonals of one kind from one plane to another, or within one plane.
#[derive(Clone, Copy)]
pub(in super::super) struct Between<'a, T> {
    pub(super) kind: Kind,
    pub(super) crossings: &'a Crossings,
    /// The planes of the lower and the upper ends.
    pub(super) planes: [Plane<'a, T>; 2],
    /// Planes from a lower to an upper end.
    pub(super) dz: usize,
    /// From a lower to an upper end.
    pub(super) step: Vec3,
}

impl<T: Sample> Between<'_, T> {
    /// The rows of upper ends that have crossed diagonals, by their numbers.
    #[inline(always)]
    pub(super) fn crossed_rows(
        &self,
        region: Region,
    ) -> impl Iterator<Item = (usize, CrossedRow<'_>)> {
        let Self { kind, crossings, .. } = *self;
        let [low, high] = self.planes.map(|plane| plane.bits);
        let words = high.row_words();
        let has_any = move |q: &usize| crossings.before(*q) != crossings.before(q + 1);
        kind.rows(region).filter(has_any).map(move |q| {
            let (low, high) = (&low.row(q - kind.dy)[..=words], &high.row(q)[..=words]);
            (q, CrossedRow { region, kind, low, high })
        })
    }

    /// Makes the vertices, by (y, x) of the upper end.
    ///
    /// Inlined into one function an instruction set.
    #[inline(always)]
    pub(in super::super) fn place(&self, placing: &Placing, out: &mut [Position]) {
        let mut out = out.iter_mut();
        let mut put = |vertex| {
            if let Some(slot) = out.next() {
                *slot = vertex;
            }
        };
        let Kind { dx, dy } = self.kind;
        let (nx, ny) = placing.dims;
        for (q, crossed) in self.crossed_rows(placing.region) {
            // Rows and columns before the first wrap round to where there is no sample.
            let row = |end: usize, r: usize| match self.planes[end].samples {
                samples if r < ny => samples.get(r * nx..)?.get(..nx),
                _ => None,
            };
            let (below, above) = (row(0, (q - 1).wrapping_sub(dy)), row(1, q - 1));
            let base =
                add(self.planes[0].origin, scale(placing.step_j, q as f64 - 1.0 - dy as f64));
            crossed.for_each(|c| {
                let a = below.and_then(|row| row.get(c.wrapping_sub(dx)));
                let b = above.and_then(|row| row.get(c));
                let t = match (a, b) {
                    (Some(a), Some(b)) => {
                        crossing(a.to_f64(), b.to_f64(), placing.level, placing.epsilon)
                    }
                    (None, _) => 1.0 - placing.epsilon,
                    (_, None) => placing.epsilon,
                };
                let from = add(base, scale(placing.step_i, c as f64 - dx as f64));
                put(along(from, self.step, t));
            });
        }
    }
}
