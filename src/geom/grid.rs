//! Where every sample of a volume lies, in RAS millimetres.

use super::vec3::{Vec3, add, scale, sub};
use super::{Affine, Dims, Space};

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
    /// Indices of this grid to those of the volume it was cut or averaged from: the identity for a
    /// volume as it was read. What voxel coordinates are measured in.
    pub to_voxel: Affine,
}

impl Grid {
    /// An evenly spaced grid.
    pub fn new(dims: Dims, affine: Affine) -> Self {
        Self { dims, affine, plane_origins: None, to_voxel: Affine::IDENTITY }
    }

    /// A grid whose planes are not evenly spaced on one line: one origin a plane. The third column
    /// of `affine` is the mean step.
    pub fn uneven(dims: Dims, affine: Affine, plane_origins: Vec<Vec3>) -> Self {
        Self { dims, affine, plane_origins: Some(plane_origins), to_voxel: Affine::IDENTITY }
    }

    /// The same samples with their places in the axes of `space`. Voxel coordinates are those of
    /// the volume as it was read, whatever was cut from it since.
    #[must_use]
    pub fn in_space(&self, space: Space) -> Self {
        let voxels = self.to_voxel;
        match space {
            Space::Ras => self.clone(),
            Space::Voxel => {
                Self { dims: self.dims, affine: voxels, plane_origins: None, to_voxel: voxels }
            }
            Space::Lps => {
                let turn = |p: Vec3| [-p[0], -p[1], p[2]];
                let [x, y, z] = *self.affine.rows();
                let affine = Affine::from_rows([x.map(|v| -v), y.map(|v| -v), z]);
                let plane_origins =
                    self.plane_origins.as_ref().map(|o| o.iter().copied().map(turn).collect());
                Self { dims: self.dims, affine, plane_origins, to_voxel: voxels }
            }
        }
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
