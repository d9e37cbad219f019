//! Area, enclosed volume and bounds, summed patch by patch.

use std::ops::Range;

use super::{Normal, Patch, Position};
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
    /// Adds one triangle and gives back its unit normal, which costs nothing where it is not used;
    /// zero where the corners lie on one line.
    #[inline]
    pub fn add(&mut self, corners: [Position; 3]) -> Normal {
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let normal = cross(sub(b, a), sub(c, a));
        let length = norm(normal);
        self.area += 0.5 * length;
        self.volume += dot(a, normal) / 6.0;
        let scale = if length > 0.0 && length < f64::INFINITY { 1.0 / length } else { 0.0 };
        normal.map(|x| (x * scale) as f32)
    }

    /// Adds some triangles of a patch, and its own vertices where they begin with the first.
    pub fn add_part(&mut self, patch: &Patch, triangles: Range<usize>) {
        if triangles.start == 0 {
            self.add_vertices(patch);
        }
        for &triangle in &patch.triangles[triangles] {
            self.add(patch.corners(triangle));
        }
    }

    /// Takes the own vertices of a patch into the box.
    pub fn add_vertices(&mut self, patch: &Patch) {
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
