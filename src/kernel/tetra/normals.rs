//! Normals at vertices on diagonals: as on grid edges, one after the other.

use super::super::normal::Surroundings;
use super::super::vertices::Placing;
use super::edges::Kind;
use super::vertices::Between;
use crate::geom::vec3::Vec3;
use crate::mesh::Normal;
use crate::volume::Sample;

impl<T: Sample> Between<'_, T> {
    /// Makes the normals of the vertices, in step with them.
    pub(super) fn normals(
        &self,
        placing: &Placing,
        around: &Surroundings<'_, T>,
        out: &mut [Normal],
    ) {
        let within = if self.dz == 0 { &around.plane } else { &around.between };
        let mut out = out.iter_mut();
        let Kind { dx, dy } = self.kind;
        for (q, crossed) in self.crossed_rows(placing.region) {
            crossed.for_each(|c| {
                let beyond = self.beyond(placing.dims, c, q - 1);
                let normal = match within {
                    Some(within) if beyond == [0.0; 3] => {
                        within.on_edge([c - dx, q - 1 - dy, 1], [c, q - 1, 1 + self.dz])
                    }
                    _ => around.cap(beyond),
                };
                if let Some(slot) = out.next() {
                    *slot = normal;
                }
            });
        }
    }

    /// On which sides of the volume a diagonal's outer end lies, along the grid's axes; on none if
    /// both ends are samples. `c` and `r` are those of the upper end.
    fn beyond(&self, (nx, ny): (usize, usize), c: usize, r: usize) -> Vec3 {
        let side = |is_before: bool, is_after: bool| f64::from(is_after) - f64::from(is_before);
        let Kind { dx, dy } = self.kind;
        let [is_before, is_after] = self.planes.map(|plane| plane.samples.is_empty());
        [side(c < dx, c >= nx), side(r < dy, r >= ny), side(is_before, is_after)]
    }
}
