//! An axis-parallel box around points.

/// The smallest box that holds the points given so far; empty at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least x, y, z; infinite while empty.
    pub min: [f64; 3],
    /// Greatest x, y, z; negative infinite while empty.
    pub max: [f64; 3],
}

impl Default for Bounds {
    fn default() -> Self {
        Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] }
    }
}

impl Bounds {
    /// Widens the box to hold `point`.
    pub fn include(&mut self, point: [f64; 3]) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(point[axis]);
            self.max[axis] = self.max[axis].max(point[axis]);
        }
    }

    /// Widens the box to hold another.
    pub fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// The largest magnitude of any coordinate; 0 while empty.
    pub fn reach(&self) -> f64 {
        self.min.iter().chain(&self.max).filter(|v| v.is_finite()).fold(0.0, |m, v| m.max(v.abs()))
    }
}
