//! From stored values to real ones.

/// real = stored · slope + inter, in `f64` with two roundings (no fused multiply-add).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rescale {
    slope: f64,
    inter: f64,
}

impl Default for Rescale {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Rescale {
    /// Stored values are the real ones.
    pub const IDENTITY: Self = Self { slope: 1.0, inter: 0.0 };

    /// With a slope that is finite and not zero, and a finite intercept; nothing otherwise.
    pub fn new(slope: f64, inter: f64) -> Option<Self> {
        (slope.is_finite() && slope != 0.0 && inter.is_finite()).then_some(Self { slope, inter })
    }

    /// The factor, never zero.
    pub fn slope(self) -> f64 {
        self.slope
    }

    /// The real value of a stored zero.
    pub fn inter(self) -> f64 {
        self.inter
    }

    /// The real value. A slope of 1 and an intercept of 0 change nothing, the sign of a zero
    /// included.
    pub fn real(self, stored: f64) -> f64 {
        let scaled = if self.slope == 1.0 { stored } else { stored * self.slope };
        if self.inter == 0.0 { scaled } else { scaled + self.inter }
    }

    /// The level in stored values that stands for a real iso value: `(iso - inter) / slope`, never
    /// rounded to a sample type.
    pub fn level(self, iso: f64) -> f64 {
        (iso - self.inter) / self.slope
    }
}
