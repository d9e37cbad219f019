//! Grids made from a grid: a box of its samples, and blocks of them.
//!
//! Only says where the new samples lie; their values are made where samples are read.

use std::ops::Range;

use super::vec3::{Vec3, add, cross, dot, norm, scale, sub};
use super::{Affine, Dims, DimsError, Grid, Space};

/// Why a box or a block does not fit a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegridError {
    /// An index range is empty or leaves the volume.
    #[error("crop {axis} {start}:{end}: the volume has {axis} 0:{n}")]
    Outside {
        /// `i`, `j` or `k`.
        axis: char,
        /// First index of the range.
        start: usize,
        /// One beyond its last index.
        end: usize,
        /// Samples along the axis.
        n: usize,
    },
    /// A box in output coordinates has an end that is not finite, or ends before it begins.
    #[error("crop box {axis} {start}:{end}: both must be finite, the end not below the start")]
    BadBox {
        /// `x`, `y` or `z`.
        axis: char,
        /// Where it begins.
        start: f64,
        /// Where it ends.
        end: f64,
    },
    /// A box in output coordinates holds no part of the volume.
    #[error(
        "the crop box does not touch the volume: it lies at {axis} {start:.1} to {end:.1}, the volume has {axis} 0:{n}"
    )]
    Misses {
        /// `i`, `j` or `k`.
        axis: char,
        /// Least index coordinate of the box.
        start: f64,
        /// Greatest index coordinate of the box.
        end: f64,
        /// Samples along the axis.
        n: usize,
    },
    /// Blocks of no samples.
    #[error("blocks of {0} x {1} x {2} samples: each must be at least 1")]
    EmptyBlock(usize, usize, usize),
    /// The map cannot be turned round.
    #[error("the affine cannot be inverted")]
    NotInvertible,
    /// The new dimensions are no size of a volume.
    #[error(transparent)]
    Dims(#[from] DimsError),
}

const AXES: [char; 3] = ['i', 'j', 'k'];

/// Index coordinates this near to a whole number are taken for it: a box that was meant to end on a
/// sample does so despite rounding.
const SNAP: f64 = 1e-6;

impl Grid {
    /// The grid of the samples in a box of half-open index ranges. They stay where they were.
    ///
    /// # Errors
    /// [`RegridError::Outside`] for a range that is empty or leaves the volume.
    pub fn cropped(&self, ranges: &[Range<usize>; 3]) -> Result<Self, RegridError> {
        for (a, range) in ranges.iter().enumerate() {
            let n = self.dims.to_array()[a];
            if range.start >= range.end || range.end > n {
                let Range { start, end } = *range;
                return Err(RegridError::Outside { axis: AXES[a], start, end, n });
            }
        }
        let [i, j, k] = ranges.clone();
        let dims = checked([i.len(), j.len(), k.len()])?;
        let first = [i.start as f64, j.start as f64, k.start as f64];
        let shift = Affine::from_rows([
            [1.0, 0.0, 0.0, first[0]],
            [0.0, 1.0, 0.0, first[1]],
            [0.0, 0.0, 1.0, first[2]],
        ]);
        let to_voxel = self.to_voxel.after(&shift);
        if self.plane_origins.is_none() {
            let affine = self.with_origin(self.affine.apply(first));
            return Ok(Self { dims, affine, plane_origins: None, to_voxel });
        }
        let in_plane =
            add(scale(self.affine.column(0), first[0]), scale(self.affine.column(1), first[1]));
        let origins = k.map(|k| add(self.plane_origin(k as i64), in_plane)).collect();
        Ok(self.with_planes(dims, origins, self.plane_step(ranges[2].start as i64), to_voxel))
    }

    /// The grid of the means of blocks of `n` samples along each axis, each at its block's centre.
    /// A last block that is short keeps the grid's step; where planes are uneven a block lies at
    /// the mean of the origins it has.
    ///
    /// # Errors
    /// [`RegridError::EmptyBlock`] where one of `n` is 0.
    pub fn blocks(&self, n: [usize; 3]) -> Result<Self, RegridError> {
        if n.contains(&0) {
            return Err(RegridError::EmptyBlock(n[0], n[1], n[2]));
        }
        let old = self.dims.to_array();
        let dims = checked([0, 1, 2].map(|a| old[a].div_ceil(n[a])))?;
        // A block larger than the axis is the whole axis: its centre must not leave the volume.
        let n = [0, 1, 2].map(|a| n[a].min(old[a]));
        let size = n.map(|n| n as f64);
        let centre = size.map(|n| (n - 1.0) / 2.0);
        let grow = Affine::from_rows([
            [size[0], 0.0, 0.0, centre[0]],
            [0.0, size[1], 0.0, centre[1]],
            [0.0, 0.0, size[2], centre[2]],
        ]);
        let to_voxel = self.to_voxel.after(&grow);
        let affine = self.affine.after(&grow);
        if self.plane_origins.is_none() {
            return Ok(Self { dims, affine, plane_origins: None, to_voxel });
        }
        let in_plane =
            add(scale(self.affine.column(0), centre[0]), scale(self.affine.column(1), centre[1]));
        let origins = (0..dims.nz())
            .map(|block| {
                let planes = block * n[2]..old[2].min((block + 1) * n[2]);
                let part = 1.0 / planes.len() as f64;
                let sum = planes.map(|k| self.plane_origin(k as i64)).fold([0.0; 3], add);
                add(scale(sum, part), in_plane)
            })
            .collect();
        let grid = Self { affine, ..self.clone() };
        Ok(grid.with_planes(dims, origins, affine.column(2), to_voxel))
    }

    /// The smallest box of half-open index ranges that covers a box in the coordinates of `space`
    /// (closed, millimetres or voxel indices), as far as the volume goes.
    ///
    /// # Errors
    /// A box that is none, or that holds no part of the volume.
    pub fn box_around(
        &self,
        space: Space,
        min: Vec3,
        max: Vec3,
    ) -> Result<[Range<usize>; 3], RegridError> {
        for a in 0..3 {
            let (start, end) = (min[a], max[a]);
            if !(start.is_finite() && end.is_finite() && start <= end) {
                return Err(RegridError::BadBox { axis: ['x', 'y', 'z'][a], start, end });
            }
        }
        let grid = self.in_space(space);
        let mut least = [f64::INFINITY; 3];
        let mut greatest = [f64::NEG_INFINITY; 3];
        for point in grid.extreme_points(min, max) {
            let index = grid.index_of(point).ok_or(RegridError::NotInvertible)?;
            for a in 0..3 {
                least[a] = least[a].min(index[a]);
                greatest[a] = greatest[a].max(index[a]);
            }
        }
        let mut ranges = [0..0, 0..0, 0..0];
        for a in 0..3 {
            let n = self.dims.to_array()[a];
            let snap = |x: f64, y: f64| if (x - x.round()).abs() < SNAP { x.round() } else { y };
            let first = snap(least[a], least[a].floor());
            let last = snap(greatest[a], greatest[a].ceil());
            if !(last >= 0.0 && first <= (n - 1) as f64) {
                let (start, end) = (least[a], greatest[a]);
                return Err(RegridError::Misses { axis: AXES[a], start, end, n });
            }
            ranges[a] = first.max(0.0) as usize..(last.min((n - 1) as f64) as usize + 1);
        }
        Ok(ranges)
    }

    /// The points of a box at which index coordinates can be extreme: its corners and, since the
    /// map bends at each plane where planes are uneven, its edges' crossings with all planes.
    fn extreme_points(&self, min: Vec3, max: Vec3) -> Vec<Vec3> {
        let corner = |c: usize| [0, 1, 2].map(|a| if c >> a & 1 == 1 { max[a] } else { min[a] });
        let mut points: Vec<Vec3> = (0..8).map(corner).collect();
        if self.plane_origins.is_none() {
            return points;
        }
        let normal = cross(self.affine.column(0), self.affine.column(1));
        for (c, a) in
            (0..8).flat_map(|c| (0..3).map(move |a| (c, a))).filter(|(c, a)| c >> a & 1 == 0)
        {
            let (from, to) = (corner(c), corner(c | 1 << a));
            let along = sub(to, from);
            let rise = dot(along, normal);
            for k in 0..self.dims.nz() as i64 {
                let t = dot(sub(self.plane_origin(k), from), normal) / rise;
                if t > 0.0 && t < 1.0 {
                    points.push(add(from, scale(along, t)));
                }
            }
        }
        points
    }

    /// The index coordinates of a point; between two planes by their true origins.
    fn index_of(&self, point: Vec3) -> Option<Vec3> {
        let Some(origins) = &self.plane_origins else {
            return Some(self.affine.inverse()?.apply(point));
        };
        let (ci, cj) = (self.affine.column(0), self.affine.column(1));
        let normal = cross(ci, cj);
        let height = |k: i64| dot(self.plane_origin(k), normal);
        let last = origins.len() as i64 - 2;
        let upward = height(last + 1) > height(0);
        let target = dot(point, normal);
        // The gap whose far plane is the first that is not before the point.
        let below = (1..=last)
            .take_while(|&k| if upward { height(k) < target } else { height(k) > target });
        let gap = below.last().unwrap_or(0);
        let local = Affine::from_columns(ci, cj, self.plane_step(gap), self.plane_origin(gap));
        let [i, j, k] = local.inverse()?.apply(point);
        Some([i, j, k + gap as f64])
    }

    /// The affine with another origin.
    fn with_origin(&self, origin: Vec3) -> Affine {
        let [i, j, k] = [0, 1, 2].map(|c| self.affine.column(c));
        Affine::from_columns(i, j, k, origin)
    }

    /// The grid with other planes; a single plane needs no list, and has `step` for its cap.
    fn with_planes(&self, dims: Dims, origins: Vec<Vec3>, step: Vec3, to_voxel: Affine) -> Self {
        let (ci, cj) = (self.affine.column(0), self.affine.column(1));
        let (first, last) = match (origins.first(), origins.last()) {
            (Some(first), Some(last)) => (*first, *last),
            _ => (self.affine.column(3), self.affine.column(3)),
        };
        let many = origins.len() >= 2;
        let step =
            if many { scale(sub(last, first), 1.0 / (origins.len() - 1) as f64) } else { step };
        let affine = Affine::from_columns(ci, cj, step, first);
        Self { dims, affine, plane_origins: many.then_some(origins), to_voxel }
    }

    /// Distances between planes along their normal in mm, where planes are uneven.
    pub fn gaps_mm(&self) -> Option<Vec<f64>> {
        let origins = self.plane_origins.as_ref()?;
        let normal = cross(self.affine.column(0), self.affine.column(1));
        let length = norm(normal);
        Some(origins.windows(2).map(|o| (dot(sub(o[1], o[0]), normal) / length).abs()).collect())
    }
}

/// The dimensions of a part: never larger than those that were checked.
fn checked(n: [usize; 3]) -> Result<Dims, DimsError> {
    Dims::checked(n[0] as i64, n[1] as i64, n[2] as i64, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oblique() -> Grid {
        let affine = Affine::from_columns(
            [0.6, 0.8, 0.0],
            [-1.6, 1.2, 0.0],
            [0.1, 0.0, 3.0],
            [10.0, -20.0, 30.0],
        );
        Grid::new(Dims::checked(9, 8, 7, 2).unwrap(), affine)
    }

    fn near(a: Vec3, b: Vec3) -> bool {
        norm(sub(a, b)) < 1e-9
    }

    #[test]
    fn the_inverse_goes_back() {
        let affine = oblique().affine;
        let p = [3.25, -1.5, 6.0];
        assert!(near(affine.inverse().unwrap().apply(affine.apply(p)), p));
        assert!(near(affine.after(&affine.inverse().unwrap()).apply(p), p));
        let flat = Affine::from_columns([1.0; 3], [1.0; 3], [0.0, 0.0, 1.0], [0.0; 3]);
        assert_eq!(flat.inverse(), None);
    }

    #[test]
    fn a_box_keeps_its_samples_in_place_and_their_indices() {
        let whole = oblique();
        let part = whole.cropped(&[2..9, 1..3, 4..6]).unwrap();
        assert_eq!(part.dims.to_array(), [7, 2, 2]);
        assert!(near(part.affine.apply([1.0, 1.0, 1.0]), whole.affine.apply([3.0, 2.0, 5.0])));
        let again = part.cropped(&[3..5, 0..1, 1..2]).unwrap();
        assert_eq!(again.to_voxel.apply([0.0; 3]), [5.0, 1.0, 5.0]);
        assert_eq!(again.in_space(Space::Voxel).affine.apply([1.0, 0.0, 0.0]), [6.0, 1.0, 5.0]);
    }

    #[test]
    fn a_range_that_is_empty_or_leaves_the_volume_is_refused_with_its_axis() {
        let grid = oblique();
        for (ranges, axis) in
            [([0..10, 0..1, 0..1], 'i'), ([0..1, 3..3, 0..1], 'j'), ([0..1, 0..1, 7..8], 'k')]
        {
            let refused = grid.cropped(&ranges);
            assert!(
                matches!(refused, Err(RegridError::Outside { axis: a, .. }) if a == axis),
                "{refused:?}"
            );
        }
    }

    #[test]
    fn a_box_of_millimetres_is_the_smallest_index_box_that_covers_it() {
        let grid = oblique();
        // All eight corners of the index box, taken to millimetres, give the box back in voxels.
        let voxels = grid.box_around(Space::Voxel, [2.0, 1.5, 0.0], [4.0, 2.5, 99.0]).unwrap();
        assert_eq!(voxels, [2..5, 1..4, 0..7]);
        let p = grid.affine.apply([3.0, 4.0, 5.0]);
        assert_eq!(grid.box_around(Space::Ras, p, p).unwrap(), [3..4, 4..5, 5..6]);
        let q = grid.affine.apply([3.5, 4.5, 5.5]);
        assert_eq!(grid.box_around(Space::Ras, q, q).unwrap(), [3..5, 4..6, 5..7]);
        let lps = [-p[0], -p[1], p[2]];
        assert_eq!(grid.box_around(Space::Lps, lps, lps).unwrap(), [3..4, 4..5, 5..6]);
        let far = grid.box_around(Space::Ras, [900.0; 3], [901.0; 3]);
        assert!(matches!(far, Err(RegridError::Misses { .. })));
        let backward = grid.box_around(Space::Voxel, [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]).unwrap_err();
        let said = "crop box y 2:1: both must be finite, the end not below the start";
        assert_eq!(backward.to_string(), said);
    }

    #[test]
    fn blocks_lie_at_the_mean_of_their_samples() {
        let whole = oblique();
        let coarse = whole.blocks([2, 3, 4]).unwrap();
        assert_eq!(coarse.dims.to_array(), [5, 3, 2]);
        let mut sum = [0.0; 3];
        for (i, j, k) in
            (2..4).flat_map(|i| (3..6).flat_map(move |j| (0..4).map(move |k| (i, j, k))))
        {
            sum = add(sum, whole.affine.apply([f64::from(i), f64::from(j), f64::from(k)]));
        }
        assert!(near(coarse.affine.apply([1.0, 1.0, 0.0]), scale(sum, 1.0 / 24.0)));
        assert_eq!(coarse.to_voxel.apply([1.0, 1.0, 0.0]), [2.5, 4.0, 1.5]);
        assert_eq!(whole.blocks([100, 1, 1]).unwrap().to_voxel.apply([0.0; 3]), [4.0, 0.0, 0.0]);
        assert!(matches!(whole.blocks([1, 0, 1]), Err(RegridError::EmptyBlock(1, 0, 1))));
    }

    #[test]
    fn uneven_planes_keep_their_origins_and_gaps() {
        let origins = vec![[0.0; 3], [0.0, 0.5, 1.0], [1.0, 0.0, 4.0], [0.0, 0.0, 5.0]];
        let affine =
            Affine::from_columns([1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 5.0 / 3.0], [0.0; 3]);
        let grid = Grid::uneven(Dims::checked(20, 20, 4, 2).unwrap(), affine, origins);
        let part = grid.cropped(&[2..5, 3..4, 1..4]).unwrap();
        assert_eq!(part.plane_origin(1), [3.0, 6.0, 4.0]);
        assert_eq!(part.gaps_mm(), Some(vec![3.0, 1.0]));
        assert_eq!(part.affine.column(2), [0.0, -0.25, 2.0]);
        let one = grid.cropped(&[0..1, 0..1, 2..3]).unwrap();
        assert_eq!((one.plane_origins.clone(), one.plane_origin(0)), (None, [1.0, 0.0, 4.0]));
        assert_eq!(one.plane_step(0), [-1.0, 0.0, 1.0]);
        let coarse = grid.blocks([1, 1, 3]).unwrap();
        assert!(near(coarse.plane_origin(0), [1.0 / 3.0, 0.5 / 3.0, 5.0 / 3.0]));
        assert_eq!(coarse.plane_origin(1), [0.0, 0.0, 5.0]);
        // Within the second gap the planes slide by one along x: a thin box meets i 2 to 4.
        let found = grid.box_around(Space::Ras, [4.0, 10.0, 1.0], [4.0, 10.0, 5.0]).unwrap();
        assert_eq!(found, [3..5, 4..6, 1..4]);
    }
}
