//! Area, enclosed volume and bounds, summed patch by patch.

use super::{Patch, Position};
use crate::geom::Bounds;
use crate::geom::vec3::{cross, dot, norm, sub};

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
    /// Adds one triangle.
    pub fn add(&mut self, corners: [Position; 3]) {
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let normal = cross(sub(b, a), sub(c, a));
        self.area += 0.5 * norm(normal);
        self.volume += dot(a, normal) / 6.0;
    }

    /// Adds the triangles and the own vertices of a patch.
    pub fn add_patch(&mut self, patch: &Patch) {
        for &triangle in &patch.triangles {
            self.add(patch.corners(triangle));
        }
        for vertex in patch.own_vertices() {
            self.bounds.include(vertex.map(f64::from));
        }
    }

    /// Adds the sums of other triangles.
    pub fn merge(&mut self, other: &Self) {
        self.area += other.area;
        self.volume += other.volume;
        self.bounds.merge(&other.bounds);
    }
}
