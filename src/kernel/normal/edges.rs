//! The edges of a plane and of a layer, in the order of their vertices.

use super::gather::{Around, Gathered};
use crate::kernel::bits::BitPlane;
use crate::kernel::vertices::for_each_bit;
use crate::mesh::Normal;
use crate::volume::Sample;

impl<T: Sample> Around<'_, T> {
    /// The normals of the vertices on the X edges of a plane, then of those on its Y edges.
    pub(in crate::kernel) fn plane(&self, bits: &BitPlane, out: &mut [Normal]) {
        let (x, y) = out.split_at_mut(bits.n_x() as usize);
        if !x.is_empty() {
            self.x(bits, x);
        }
        if !y.is_empty() {
            self.y(bits, y);
        }
    }

    fn x(&self, bits: &BitPlane, out: &mut [Normal]) {
        let (nx, ny) = self.placing.dims;
        let caps = [-1.0, 1.0].map(|x| self.direction([x, 0.0, 0.0]));
        let mut gathered = Gathered::new();
        let mut slot = 0;
        for r in 0..ny {
            if bits.x_before(r + 1) == bits.x_before(r + 2) {
                continue;
            }
            let is_within = r >= 1 && r + 1 < ny;
            let words = &bits.row(r + 1)[..=bits.row_words()];
            for w in 0..bits.row_words() {
                let word = words[w + 1];
                let crossed = word ^ (word << 1 | words[w] >> 63);
                for_each_bit(crossed, w * 64, |c| {
                    if c == 0 || c == nx {
                        if self.placing.open {
                            return;
                        }
                        put(out, slot, caps[usize::from(c != 0)]);
                    } else {
                        let place = r * nx + c - 1;
                        if is_within && c >= 2 && c + 1 < nx {
                            gathered.add::<0>(self, place, slot, out);
                        } else {
                            put(out, slot, self.single::<0>(place));
                        }
                    }
                    slot += 1;
                });
            }
        }
        gathered.flush::<0>(self, out);
    }

    fn y(&self, bits: &BitPlane, out: &mut [Normal]) {
        let (nx, ny) = self.placing.dims;
        let (first, last) = if self.placing.open { (1, ny) } else { (0, ny + 1) };
        let caps = [-1.0, 1.0].map(|y| self.direction([0.0, y, 0.0]));
        let mut gathered = Gathered::new();
        let mut slot = 0;
        for r in first..last {
            if bits.y_before(r + 1) == bits.y_before(r + 2) {
                continue;
            }
            let is_cap = r == 0 || r == ny;
            let is_within = r >= 2 && r + 1 < ny;
            let words = (&bits.row(r)[..=bits.row_words()], &bits.row(r + 1)[..=bits.row_words()]);
            for w in 0..bits.row_words() {
                for_each_bit(words.0[w + 1] ^ words.1[w + 1], w * 64, |c| {
                    if is_cap {
                        put(out, slot, caps[usize::from(r != 0)]);
                    } else {
                        let place = (r - 1) * nx + c;
                        if is_within && c >= 1 && c + 1 < nx {
                            gathered.add::<1>(self, place, slot, out);
                        } else {
                            put(out, slot, self.single::<1>(place));
                        }
                    }
                    slot += 1;
                });
            }
        }
        gathered.flush::<1>(self, out);
    }

    /// The normals of the vertices on the Z edges between two planes.
    pub(in crate::kernel) fn z(&self, [prev, cur]: [&BitPlane; 2], out: &mut [Normal]) {
        let (nx, ny) = self.placing.dims;
        let mut gathered = Gathered::new();
        let mut slot = 0;
        for r in 0..ny {
            if !prev.any(r + 1) && !cur.any(r + 1) {
                continue;
            }
            let is_within = r >= 1 && r + 1 < ny;
            let words =
                (&prev.row(r + 1)[..=prev.row_words()], &cur.row(r + 1)[..=cur.row_words()]);
            for w in 0..prev.row_words() {
                for_each_bit(words.0[w + 1] ^ words.1[w + 1], w * 64, |c| {
                    let place = r * nx + c;
                    if is_within && c >= 1 && c + 1 < nx {
                        gathered.add::<2>(self, place, slot, out);
                    } else {
                        put(out, slot, self.single::<2>(place));
                    }
                    slot += 1;
                });
            }
        }
        gathered.flush::<2>(self, out);
    }
}

#[inline(always)]
fn put(out: &mut [Normal], slot: usize, normal: Normal) {
    if let Some(place) = out.get_mut(slot) {
        *place = normal;
    }
}
