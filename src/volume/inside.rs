//! Which real values are inside.

/// Which side of the iso value is inside, in real values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Side {
    /// value ≥ iso.
    #[default]
    AtLeast,
    /// value < iso.
    Below,
}

/// An iso value with the side of it that is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// The iso value, in real units.
    pub iso: f64,
    /// The side of it that is inside.
    pub side: Side,
}

impl Inside {
    /// Whether a real value is inside. NaN never is.
    pub fn holds(self, real: f64) -> bool {
        match self.side {
            Side::AtLeast => real >= self.iso,
            Side::Below => real < self.iso,
        }
    }
}
