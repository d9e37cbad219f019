//! Area, enclosed volume and bounds, summed patch by patch, and the triangles' normals on the way.

use super::{Patch, Position, Triangle};
use crate::geom::Bounds;

/// Triangles computed side by side.
const LANES: usize = 8;

/// One number for each of some triangles.
type Lanes<T> = [T; LANES];

/// Sums over triangles seen so far, in `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    /// Area in square output units.
    pub area: f64,
    /// Enclosed volume in cubic output units: positive where triangles are wound outward
    /// (divergence theorem, tetrahedra to the origin).
    pub volume: f64,
    /// The box around the triangles' corners.
    pub bounds: Bounds,
}

impl Measure {
    /// The sums over a patch's triangles and own vertices; leaves the triangles' unit normals in
    /// the patch.
    pub fn of(patch: &mut Patch) -> Self {
        let mut normals = std::mem::take(&mut patch.face_normals);
        normals.resize(patch.triangles.len(), [0.0; 3]);
        let (mut area, mut volume) = ([0.0; LANES], [0.0; LANES]);
        for (triangles, normals) in patch.triangles.chunks(LANES).zip(normals.chunks_mut(LANES)) {
            let faces = Faces::of(&corners(patch, triangles));
            for lane in 0..LANES {
                area[lane] += faces.double_area[lane];
                volume[lane] += faces.sixfold_volume[lane];
            }
            for (lane, normal) in normals.iter_mut().enumerate() {
                *normal = [0, 1, 2].map(|axis: usize| faces.normal[axis][lane]);
            }
        }
        patch.face_normals = normals;
        let (area, volume) = (area.iter().sum::<f64>() / 2.0, volume.iter().sum::<f64>() / 6.0);
        let mut bounds = Bounds::default();
        for vertex in patch.own_vertices() {
            bounds.include(vertex.map(f64::from));
        }
        Self { area, volume, bounds }
    }

    /// Adds one triangle.
    pub fn add(&mut self, triangle: [Position; 3]) {
        let corners = triangle.map(|corner| corner.map(|x| [x; LANES]));
        let faces = Faces::of(&corners);
        self.area += faces.double_area[0] / 2.0;
        self.volume += faces.sixfold_volume[0] / 6.0;
    }

    /// Adds the sums of other triangles.
    pub fn merge(&mut self, other: &Self) {
        self.area += other.area;
        self.volume += other.volume;
        self.bounds.merge(&other.bounds);
    }
}

/// The unit normal of a triangle, zero where its corners lie on one line.
pub(super) fn face_normal(triangle: [Position; 3]) -> [f32; 3] {
    let faces = Faces::of(&triangle.map(|corner| corner.map(|x| [x; LANES])));
    faces.normal.map(|axis| axis[0])
}

/// The coordinates of the corners, each axis by itself. Lanes beyond the triangles hold points.
fn corners(patch: &Patch, triangles: &[Triangle]) -> [[Lanes<f32>; 3]; 3] {
    let mut corners = [[[0.0; LANES]; 3]; 3];
    for (lane, &triangle) in triangles.iter().enumerate().take(LANES) {
        for (corner, position) in corners.iter_mut().zip(patch.corners(triangle)) {
            for (axis, x) in corner.iter_mut().zip(position) {
                axis[lane] = x;
            }
        }
    }
    corners
}

/// What some triangles come to.
struct Faces {
    double_area: Lanes<f64>,
    sixfold_volume: Lanes<f64>,
    /// Of unit length, by axis; zero where the corners lie on one line.
    normal: [Lanes<f32>; 3],
}

impl Faces {
    #[inline(always)]
    fn of(corners: &[[Lanes<f32>; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        let side = |to: &[Lanes<f32>; 3], axis: usize| -> Lanes<f64> {
            std::array::from_fn(|l| f64::from(to[axis][l]) - f64::from(a[axis][l]))
        };
        let u = [side(b, 0), side(b, 1), side(b, 2)];
        let v = [side(c, 0), side(c, 1), side(c, 2)];
        let cross = |p: usize, q: usize| -> Lanes<f64> {
            std::array::from_fn(|l| u[p][l] * v[q][l] - u[q][l] * v[p][l])
        };
        let n = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let square: Lanes<f64> =
            std::array::from_fn(|l| n[0][l] * n[0][l] + n[1][l] * n[1][l] + n[2][l] * n[2][l]);
        let double_area = square.map(f64::sqrt);
        let scale: Lanes<f64> = std::array::from_fn(|l| {
            let is_proper = square[l] > 0.0 && square[l] < f64::INFINITY;
            if is_proper { 1.0 / double_area[l] } else { 0.0 }
        });
        let volume = |l: usize| {
            f64::from(a[0][l]) * n[0][l]
                + f64::from(a[1][l]) * n[1][l]
                + f64::from(a[2][l]) * n[2][l]
        };
        Self {
            double_area,
            sixfold_volume: std::array::from_fn(volume),
            normal: n.map(|n| std::array::from_fn(|l| (n[l] * scale[l]) as f32)),
        }
    }
}
