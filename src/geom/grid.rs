//! Where every sample of a volume lies, in RAS millimetres.

use super::vec3::{Vec3, add, scale, sub};
use super::{Affine, Dims};

/// Dimensions, the affine, and, where planes are not evenly spaced on one line, the origin of each
/// plane. All in RAS millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Samples along i, j, k.
    pub dims: Dims,
    /// Voxel indices to RAS millimetres. With uneven planes its third column is the mean step.
    pub affine: Affine,
    /// The centre of sample (0, 0, k) for each plane k, where the affine alone does not give it.
    /// Holds `nz` points, `nz` at least 2.
    pub plane_origins: Option<Vec<Vec3>>,
}

impl Grid {
    /// An evenly spaced grid.
    pub fn new(dims: Dims, affine: Affine) -> Self {
        Self { dims, affine, plane_origins: None }
    }

    /// The centre of sample (0, 0, k). Beyond the volume (`k` = -1 or `nz`, the border) uneven
    /// planes continue their first or last gap.
    pub fn plane_origin(&self, k: i64) -> Vec3 {
        let even = || {
            let (step, origin) = (self.affine.column(2), self.affine.column(3));
            add(origin, scale(step, k as f64))
        };
        let Some(origins) = self.plane_origins.as_deref().filter(|o| o.len() >= 2) else {
            return even();
        };
        let last = origins.len() - 1;
        match usize::try_from(k) {
            Err(_) => {
                let gap = sub(origins[1], origins[0]);
                add(origins[0], scale(gap, k as f64))
            }
            Ok(k) if k <= last => origins[k],
            Ok(k) => {
                let gap = sub(origins[last], origins[last - 1]);
                add(origins[last], scale(gap, (k - last) as f64))
            }
        }
    }

    /// The step from plane `k` to plane `k + 1`, the same for all `k` on an even grid.
    pub fn plane_step(&self, k: i64) -> Vec3 {
        if self.plane_origins.is_some() {
            sub(self.plane_origin(k + 1), self.plane_origin(k))
        } else {
            self.affine.column(2)
        }
    }
}
