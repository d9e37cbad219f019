//! Vertices: one for each grid edge whose ends differ, made once.
//!
//! Positions are `f64` arithmetic in one order, rounded once; of normals `normal` tells.

use super::bits::BitPlane;
use super::family::Family;
use super::gather::Gathered;
use super::layer::ActiveWord;
use super::normal::Surroundings;
use super::region::Region;
use crate::geom::vec3::Vec3;
use crate::mesh::{Normal, Position};
use crate::volume::Sample;

/// What places a vertex: the numbers of the map, and those of the interpolation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placing {
    pub(super) step_i: Vec3,
    pub(super) step_j: Vec3,
    pub(super) level: f64,
    pub(super) epsilon: f64,
    pub(super) dims: (usize, usize),
    pub(super) region: Region,
}

/// A plane of samples, or of the border, where it lies.
#[derive(Clone, Copy)]
pub(super) struct Plane<'a, T> {
    pub(super) bits: &'a BitPlane,
    /// None in the border.
    pub(super) samples: &'a [T],
    /// Of the sample (0, 0).
    pub(super) origin: Vec3,
}

/// Room for some vertices, and for a normal of each where normals are wanted.
#[derive(Default)]
pub(super) struct Slots<'a> {
    pub(super) positions: &'a mut [Position],
    pub(super) normals: Option<&'a mut [Normal]>,
}

impl Slots<'_> {
    /// The first `n` and the rest; all, and nothing, where there are fewer.
    #[inline(always)]
    pub(super) fn split_at(self, n: usize) -> (Self, Self) {
        let n = n.min(self.positions.len());
        let (positions, more_positions) = self.positions.split_at_mut(n);
        let (normals, more_normals) = match self.normals {
            Some(normals) => {
                let (normals, more) = normals.split_at_mut(n.min(normals.len()));
                (Some(normals), Some(more))
            }
            None => (None, None),
        };
        let rest = Self { positions: more_positions, normals: more_normals };
        (Self { positions, normals }, rest)
    }
}

/// Where the vertices of a layer go: those on its Z edges, and on the X and Y edges of the plane
/// after it.
pub(super) struct LayerSlots<'a> {
    pub(super) z: Slots<'a>,
    pub(super) x: Slots<'a>,
    pub(super) y: Slots<'a>,
}

/// The crossed grid edges of a layer, and all that their vertices are made of.
pub(super) struct LayerEdges<'a, T> {
    pub(super) placing: &'a Placing,
    /// Those that hold crossings.
    pub(super) words: &'a [ActiveWord],
    /// The planes before the layer and after it, one `step` apart.
    pub(super) planes: [Plane<'a, T>; 2],
    pub(super) step: Vec3,
    /// What normals are made of, where they are wanted.
    pub(super) around: Option<Surroundings<'a, T>>,
}

/// What an instruction set does with crossings: gathers those of a word (whose first bit stands for
/// a place in a row), and makes what is wanted of all that are gathered.
pub(super) struct Instructions<G, P> {
    pub(super) gather: G,
    pub(super) place: P,
}

impl<T: Sample> LayerEdges<'_, T> {
    /// Makes the vertices, each family by (y, x).
    ///
    /// Inlined into one function an instruction set, as the others here.
    #[inline(always)]
    pub(super) fn make_with<G, P>(&self, out: LayerSlots<'_>, with: &Instructions<G, P>)
    where
        G: Fn(&mut Gathered, u64, u32, u32),
        P: Fn(&Family<'_, T>, &Gathered, Slots<'_>),
    {
        let Self { placing, planes: [before, after], .. } = self;
        let outer = self.around.as_ref().map_or([&[] as &[T]; 2], Surroundings::outer_planes);
        let mut x = Edges::new(Family::x(placing, after), out.x);
        let mut y = Edges::new(Family::y(placing, after), out.y);
        let mut z = Edges::new(Family::z(placing, [before, after], self.step), out.z);
        let in_border = before.samples.is_empty() || after.samples.is_empty();
        let (region, has_z) = (placing.region, placing.region.has_layer(in_border));
        for &ActiveWord { q, w } in self.words {
            let (at, w) = (q as usize, w as usize);
            // Since they were compared the samples may have left the nearer caches.
            let from = (at - 1) * placing.dims.0 + 64 * w;
            super::simd::ask(before.samples, from);
            super::simd::ask(after.samples, from);
            if self.around.is_some() {
                for plane in outer {
                    super::simd::ask(plane, from);
                }
            }
            x.add(after.bits.x_crossings(region, at, w), w, q - 1, with);
            y.add(after.bits.y_crossings(region, at, w), w, q - 1, with);
            if has_z {
                z.add(before.bits.word(at, w) ^ after.bits.word(at, w), w, q - 1, with);
            }
        }
        x.flush(with);
        y.flush(with);
        z.flush(with);
    }
}

impl Placing {
    /// The vertices on the X edges of a plane, then those on its Y edges.
    #[inline(always)]
    pub(super) fn ghosts_with<T: Sample, G, P>(
        &self,
        plane: Plane<'_, T>,
        out: &mut [Position],
        with: &Instructions<G, P>,
    ) where
        G: Fn(&mut Gathered, u64, u32, u32),
        P: Fn(&Family<'_, T>, &Gathered, Slots<'_>),
    {
        let bits = plane.bits;
        let (x, y) = Slots { positions: out, normals: None }.split_at(bits.n_x() as usize);
        let mut x = Edges::new(Family::x(self, &plane), x);
        let mut y = Edges::new(Family::y(self, &plane), y);
        let rows = bits.some_rows();
        for q in rows.start..=rows.end {
            for w in 0..bits.row_words() {
                let (i, j) =
                    (bits.x_crossings(self.region, q, w), bits.y_crossings(self.region, q, w));
                if i | j != 0 {
                    x.add(i, w, q as u32 - 1, with);
                    y.add(j, w, q as u32 - 1, with);
                }
            }
        }
        x.flush(with);
        y.flush(with);
    }
}

/// The crossed edges of one family on their way to vertices.
struct Edges<'a, 'o, T> {
    family: Family<'a, T>,
    gathered: Gathered,
    out: Slots<'o>,
}

impl<'a, 'o, T: Sample> Edges<'a, 'o, T> {
    fn new(family: Family<'a, T>, out: Slots<'o>) -> Self {
        Self { family, gathered: Gathered::new(), out }
    }

    /// Adds the edges of word `w` in row `r`.
    #[inline(always)]
    fn add<G, P>(&mut self, crossed: u64, w: usize, r: u32, with: &Instructions<G, P>)
    where
        G: Fn(&mut Gathered, u64, u32, u32),
        P: Fn(&Family<'_, T>, &Gathered, Slots<'_>),
    {
        if self.gathered.is_full() {
            self.flush(with);
        }
        (with.gather)(&mut self.gathered, crossed, 64 * w as u32, r);
    }

    /// Places all that is gathered.
    #[inline(always)]
    fn flush<G, P>(&mut self, with: &Instructions<G, P>)
    where
        P: Fn(&Family<'_, T>, &Gathered, Slots<'_>),
    {
        let (now, later) = std::mem::take(&mut self.out).split_at(self.gathered.len());
        (with.place)(&self.family, &self.gathered, now);
        self.out = later;
        self.gathered.clear();
    }
}
