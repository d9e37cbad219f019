//! Vertices: one for each grid edge whose ends differ, made once.
//!
//! All arithmetic is `f64`, in one order, rounded once. A row's constants are computed once a row.

use super::bits::BitPlane;
use super::crossing;
use crate::geom::vec3::{Vec3, add, scale};
use crate::mesh::Position;
use crate::volume::Sample;

/// What places a vertex: the numbers of the map, and those of the interpolation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placing {
    pub(super) step_i: Vec3,
    pub(super) step_j: Vec3,
    pub(super) level: f64,
    pub(super) epsilon: f64,
    pub(super) dims: (usize, usize),
    pub(super) open: bool,
}

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

impl Placing {
    /// The vertices on the X edges of a plane whose sample (0, 0) lies at `origin`, then those on
    /// its Y edges.
    #[inline(always)]
    pub(super) fn plane<T: Sample>(
        &self,
        bits: &BitPlane,
        samples: &[T],
        origin: Vec3,
        out: &mut [Position],
    ) {
        let (x, y) = out.split_at_mut(bits.n_x() as usize);
        self.x(bits, samples, origin, x);
        self.y(bits, samples, origin, y);
    }

    /// The vertices on the X edges of a plane whose sample (0, 0) lies at `origin`, by (y, x).
    #[inline(always)]
    fn x<T: Sample>(&self, bits: &BitPlane, samples: &[T], origin: Vec3, out: &mut [Position]) {
        let mut out = out.iter_mut();
        let mut put = |vertex| {
            if let Some(slot) = out.next() {
                *slot = vertex;
            }
        };
        let (nx, ny) = self.dims;
        for r in 0..ny {
            if bits.x_before(r + 1) == bits.x_before(r + 2) {
                continue;
            }
            let base = add(origin, scale(self.step_j, r as f64));
            let row = &samples[r * nx..][..nx];
            let words = &bits.row(r + 1)[..=bits.row_words()];
            for w in 0..bits.row_words() {
                let word = words[w + 1];
                let crossed = word ^ (word << 1 | words[w] >> 63);
                for_each_bit(crossed, w * 64, |c| {
                    let t = if c == 0 || c == nx {
                        if self.open {
                            return;
                        }
                        if c == 0 { 1.0 - self.epsilon } else { self.epsilon }
                    } else {
                        crossing(row[c - 1].to_f64(), row[c].to_f64(), self.level, self.epsilon)
                    };
                    put(along(base, self.step_i, c as f64 - 1.0 + t));
                });
            }
        }
    }

    /// The vertices on the Y edges of a plane, by (y, x).
    #[inline(always)]
    fn y<T: Sample>(&self, bits: &BitPlane, samples: &[T], origin: Vec3, out: &mut [Position]) {
        let mut out = out.iter_mut();
        let mut put = |vertex| {
            if let Some(slot) = out.next() {
                *slot = vertex;
            }
        };
        let (nx, ny) = self.dims;
        let (first, last) = if self.open { (1, ny) } else { (0, ny + 1) };
        for r in first..last {
            if bits.y_before(r + 1) == bits.y_before(r + 2) {
                continue;
            }
            let in_border = r == 0 || r == ny;
            // In the border neither row is looked at.
            let above = if in_border { &[][..] } else { &samples[(r - 1) * nx..][..nx] };
            let below = if in_border { &[][..] } else { &samples[r * nx..][..nx] };
            let words = (&bits.row(r)[..=bits.row_words()], &bits.row(r + 1)[..=bits.row_words()]);
            for w in 0..bits.row_words() {
                for_each_bit(words.0[w + 1] ^ words.1[w + 1], w * 64, |c| {
                    let t = if in_border {
                        if r == 0 { 1.0 - self.epsilon } else { self.epsilon }
                    } else {
                        crossing(above[c].to_f64(), below[c].to_f64(), self.level, self.epsilon)
                    };
                    let base = add(origin, scale(self.step_j, r as f64 - 1.0 + t));
                    put(along(base, self.step_i, c as f64));
                });
            }
        }
    }

    /// The vertices on the Z edges of a layer, by (y, x): from the plane before, whose sample
    /// (0, 0) lies at `origin`, one `step` on. A plane outside the volume has no samples.
    #[inline(always)]
    pub(super) fn z<T: Sample>(
        &self,
        [prev, cur]: [&BitPlane; 2],
        [before, after]: [Option<&[T]>; 2],
        (origin, step): (Vec3, Vec3),
        out: &mut [Position],
    ) {
        let mut out = out.iter_mut();
        let mut put = |vertex| {
            if let Some(slot) = out.next() {
                *slot = vertex;
            }
        };
        let (nx, ny) = self.dims;
        let cap = if before.is_none() { 1.0 - self.epsilon } else { self.epsilon };
        for r in 0..ny {
            if !prev.any(r + 1) && !cur.any(r + 1) {
                continue;
            }
            let base = add(origin, scale(self.step_j, r as f64));
            let ends = match (before, after) {
                (Some(before), Some(after)) => {
                    Some((&before[r * nx..][..nx], &after[r * nx..][..nx]))
                }
                _ => None,
            };
            let words =
                (&prev.row(r + 1)[..=prev.row_words()], &cur.row(r + 1)[..=cur.row_words()]);
            for w in 0..prev.row_words() {
                for_each_bit(words.0[w + 1] ^ words.1[w + 1], w * 64, |c| {
                    let t = match ends {
                        Some((before, after)) => crossing(
                            before[c].to_f64(),
                            after[c].to_f64(),
                            self.level,
                            self.epsilon,
                        ),
                        None => cap,
                    };
                    put(along(add(base, scale(self.step_i, c as f64)), step, t));
                });
            }
        }
    }
}
