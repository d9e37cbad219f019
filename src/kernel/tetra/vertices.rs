//! Vertices on diagonals: as on grid edges, from the lower sample to the upper one.

use super::super::crossing;
use super::super::vertices::{Placing, Plane};
use super::edges::{Crossings, Kind, Region};
use crate::geom::vec3::{Vec3, add, scale};
use crate::mesh::Position;
use crate::volume::Sample;

/// `p + s · v`, rounded to output coordinates.
#[inline(always)]
fn along(p: Vec3, v: Vec3, s: f64) -> Position {
    [(p[0] + s * v[0]) as f32, (p[1] + s * v[1]) as f32, (p[2] + s * v[2]) as f32]
}

/// Calls `f` with each set bit's number, rising.
#[inline(always)]
pub(super) fn for_each_bit(word: u64, first: usize, mut f: impl FnMut(usize)) {
    let mut word = word;
    while word != 0 {
        f(first + word.trailing_zeros() as usize);
        word &= word - 1;
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
        let region = Region { dims: placing.dims, open: placing.open };
        let [low, high] = self.planes.map(|plane| plane.bits);
        let words = high.row_words();
        for q in region.rows(self.kind) {
            if self.crossings.before(q) == self.crossings.before(q + 1) {
                continue;
            }
            // Rows and columns before the first wrap round to where there is no sample.
            let row = |end: usize, r: usize| match self.planes[end].samples {
                samples if r < ny => samples.get(r * nx..)?.get(..nx),
                _ => None,
            };
            let (below, above) = (row(0, (q - 1).wrapping_sub(dy)), row(1, q - 1));
            let base =
                add(self.planes[0].origin, scale(placing.step_j, q as f64 - 1.0 - dy as f64));
            let (low, high) = (&low.row(q - dy)[..=words], &high.row(q)[..=words]);
            for w in 0..words {
                for_each_bit(region.crossed(self.kind, low, high, w), w * 64, |c| {
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
}
