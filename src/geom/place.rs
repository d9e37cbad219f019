//! The one map that the kernel applies: voxel indices to output coordinates.

use super::vec3::{Vec3, cross, dot};
use super::{Affine, Bounds, Dims, Grid, Space};

/// Voxel indices to output coordinates, composed once in `f64` (space included). The kernel takes
/// its numbers as they are and rounds each coordinate to `f32` once.
#[derive(Clone, Debug)]
pub struct Place {
    grid: Grid,
    space: Space,
    reversed: bool,
    epsilon: f64,
}

/// Why a volume cannot be placed in the space asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlaceError {
    /// `f32` coordinates there are too coarse for the voxels.
    #[error(
        "voxels of {step} at coordinates up to {reach} cannot be told apart in the 32-bit floats of mesh files"
    )]
    OutOfRange {
        /// The least distance between neighbouring samples, in output units.
        step: f64,
        /// The largest coordinate.
        reach: f64,
    },
    /// A corner of the volume is nowhere.
    #[error("the volume's corners have coordinates that are no finite numbers")]
    NotFinite,
    /// Planes that do not follow each other along one direction.
    #[error("plane {0} lies beyond the plane after it")]
    PlaneOrder(usize),
    /// Planes without an origin of their own, or origins without a plane.
    #[error("the grid has origins for {found} planes, the volume has {expected}")]
    PlaneOrigins {
        /// Origins that there are.
        found: usize,
        /// Planes.
        expected: usize,
    },
}

impl Place {
    /// The least distance a vertex keeps from either end of its grid edge, where `f32` is fine
    /// enough, in steps of the edge.
    pub const LEAST_EPSILON: f64 = 1.0 / 1024.0;

    /// Above this a note says that vertices may be off.
    pub const COARSE_EPSILON: f64 = 1.0 / 64.0;

    /// Above this the volume is refused.
    pub const WORST_EPSILON: f64 = 1.0 / 8.0;

    /// Composes a volume's geometry with an output space.
    ///
    /// # Errors
    /// [`PlaceError::OutOfRange`] where `f32` coordinates are too coarse for the promise that no
    /// two vertices coincide; [`PlaceError::NotFinite`]; [`PlaceError::PlaneOrigins`];
    /// [`PlaceError::PlaneOrder`].
    pub fn new(grid: &Grid, space: Space) -> Result<Self, PlaceError> {
        let grid = grid.in_space(space);
        let (found, expected) = (grid.plane_origins.as_ref().map(Vec::len), grid.dims.nz());
        if let Some(found) = found.filter(|&found| found != expected) {
            return Err(PlaceError::PlaneOrigins { found, expected });
        }
        let across = grid.plane_origins.as_ref().map_or(grid.affine.column(2), |_| {
            let last = grid.dims.nz() as i64;
            super::vec3::sub(grid.plane_origin(last), grid.plane_origin(-1))
        });
        let normal = cross(grid.affine.column(0), grid.affine.column(1));
        let reversed = dot(normal, across) < 0.0;
        let epsilon = epsilon(&grid)?;
        let follows = |k: usize| (dot(normal, grid.plane_step(k as i64)) < 0.0) == reversed;
        if let Some(k) = (0..expected.saturating_sub(1)).find(|&k| !follows(k)) {
            return Err(PlaceError::PlaneOrder(k));
        }
        Ok(Self { grid, space, reversed, epsilon })
    }

    /// Of the volume that is placed.
    pub fn dims(&self) -> Dims {
        self.grid.dims
    }

    /// The space of the output.
    pub fn space(&self) -> Space {
        self.space
    }

    /// The step along i.
    pub fn step_i(&self) -> Vec3 {
        self.grid.affine.column(0)
    }

    /// The step along j.
    pub fn step_j(&self) -> Vec3 {
        self.grid.affine.column(1)
    }

    /// The step from plane `k` to plane `k + 1`; `k` from -1 to `nz - 1`.
    pub fn step_k(&self, k: i64) -> Vec3 {
        self.grid.plane_step(k)
    }

    /// The centre of sample (0, 0, k); `k` from -1 to `nz`, the border included.
    pub fn plane_origin(&self, k: i64) -> Vec3 {
        self.grid.plane_origin(k)
    }

    /// Whether the map mirrors, so that triangles must be wound the other way round.
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    /// ε: how near a vertex may come to an end of its grid edge, as a part of the edge.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }
}

/// max(2⁻¹⁰, 16 u / σ): u the spacing of `f32` numbers at the largest coordinate of the volume with
/// its border, σ the least singular value of the map, over all gaps where planes are uneven.
///
/// The least altitude of a triangle on three edges of a cell is 0.7 ε of a step, so 16 roundings
/// leave it well above zero.
fn epsilon(grid: &Grid) -> Result<f64, PlaceError> {
    let (nx, ny, nz) = (grid.dims.nx() as f64, grid.dims.ny() as f64, grid.dims.nz() as i64);
    let (ci, cj) = (grid.affine.column(0), grid.affine.column(1));
    let mut bounds = Bounds::default();
    let ends: Vec<i64> =
        if grid.plane_origins.is_some() { (-1..=nz).collect() } else { vec![-1, nz] };
    for &k in &ends {
        let origin = grid.plane_origin(k);
        for (i, j) in [(-1.0, -1.0), (nx, -1.0), (-1.0, ny), (nx, ny)] {
            let corner = [0, 1, 2].map(|a| origin[a] + i * ci[a] + j * cj[a]);
            if !corner.iter().all(|x| x.is_finite()) {
                return Err(PlaceError::NotFinite);
            }
            bounds.include(corner);
        }
    }
    let least =
        |k: i64| Affine::from_columns(ci, cj, grid.plane_step(k), [0.0; 3]).least_singular_value();
    let gaps = if grid.plane_origins.is_some() { -1..nz } else { 0..1 };
    let step = gaps.map(least).fold(f64::INFINITY, f64::min);
    let reach = bounds.reach();
    let epsilon = Place::LEAST_EPSILON.max(16.0 * f32_spacing(reach) / step);
    // Written so that a NaN is refused too.
    if epsilon <= Place::WORST_EPSILON {
        Ok(epsilon)
    } else {
        Err(PlaceError::OutOfRange { step, reach })
    }
}

/// The distance between neighbouring `f32` numbers at magnitude `x`; infinite beyond their range.
fn f32_spacing(x: f64) -> f64 {
    let x = x as f32;
    if x.is_finite() { f64::from(x.next_up()) - f64::from(x) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Dims;

    fn grid(affine: Affine) -> Grid {
        Grid::new(Dims::checked(10, 10, 10, 2).unwrap(), affine)
    }

    #[test]
    fn lps_negates_x_and_y_and_keeps_handedness() {
        let place = Place::new(&grid(Affine::IDENTITY), Space::Lps).unwrap();
        assert_eq!(place.step_i(), [-1.0, 0.0, 0.0]);
        assert!(!place.is_reversed());
    }

    #[test]
    fn a_mirrored_map_reverses_the_winding_and_voxels_never_do() {
        let mut rows = *Affine::IDENTITY.rows();
        rows[0][0] = -1.0;
        let mirrored = grid(Affine::from_rows(rows));
        assert!(Place::new(&mirrored, Space::Ras).unwrap().is_reversed());
        assert!(!Place::new(&mirrored, Space::Voxel).unwrap().is_reversed());
    }

    #[test]
    fn far_coordinates_widen_epsilon_and_then_are_refused() {
        let at = |x: f64| {
            let mut rows = *Affine::IDENTITY.rows();
            rows[0][3] = x;
            Place::new(&grid(Affine::from_rows(rows)), Space::Ras)
        };
        assert!((at(100.0).unwrap().epsilon() - Place::LEAST_EPSILON).abs() < 1e-15);
        assert!(at(20_000.0).unwrap().epsilon() > Place::COARSE_EPSILON);
        assert!(matches!(at(1e7), Err(PlaceError::OutOfRange { .. })));
        assert!(matches!(at(1e300), Err(PlaceError::OutOfRange { .. })));
        for nowhere in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(at(nowhere).unwrap_err(), PlaceError::NotFinite);
        }
    }
}
