//! What formulas say of the surfaces.

use std::f64::consts::{PI, TAU};

use super::Shape;
use super::shape::Sizes;

/// What is known of a phantom's surface at [`Shape::iso`]; nothing where no formula says it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Truth {
    /// Square millimetres.
    pub area_mm2: Option<f64>,
    /// Cubic millimetres.
    pub volume_mm3: Option<f64>,
    /// Vertices less edges plus faces of a mesh of it.
    pub euler: Option<i64>,
}

pub(super) fn truth(shape: Shape, extent: [f64; 3]) -> Truth {
    let sizes = Sizes::new(extent);
    let known = |area, volume, euler| Truth {
        area_mm2: Some(area),
        volume_mm3: Some(volume),
        euler: Some(euler),
    };
    match shape {
        Shape::Sphere => {
            let r = sizes.radius;
            known(4.0 * PI * r * r, 4.0 / 3.0 * PI * r * r * r, 2)
        }
        Shape::Ellipsoid => {
            let [a, b, c] = sizes.axes;
            known(ellipsoid_area(sizes.axes), 4.0 / 3.0 * PI * a * b * c, 2)
        }
        Shape::Torus => {
            let (ring, tube) = (sizes.ring, sizes.tube);
            known(TAU * TAU * ring * tube, TAU * PI * ring * tube * tube, 0)
        }
        // The field is odd around the middle of the box, so half of the box is inside.
        Shape::Gyroid => {
            Truth { volume_mm3: Some(extent.iter().product::<f64>() / 2.0), ..Truth::default() }
        }
        Shape::Metaballs | Shape::Skull => Truth::default(),
    }
}

/// The integral of the area element over the unit sphere, u = cos θ by Simpson's rule, φ in even
/// steps: to about ten digits.
fn ellipsoid_area([a, b, c]: [f64; 3]) -> f64 {
    const N_U: usize = 2000;
    const N_PHI: usize = 256;
    let ring = |u: f64| -> f64 {
        let flat = 1.0 - u * u;
        let element = |n: usize| {
            let (sin, cos) = (TAU * n as f64 / N_PHI as f64).sin_cos();
            let (p, q, r) = (b * c * cos, a * c * sin, a * b * u);
            (flat * (p * p + q * q) + r * r).sqrt()
        };
        (0..N_PHI).map(element).sum::<f64>() * TAU / N_PHI as f64
    };
    let weight = |n: usize| match n {
        0 | N_U => 1.0,
        n if n % 2 == 1 => 4.0,
        _ => 2.0,
    };
    // The two halves are alike.
    let sum: f64 = (0..=N_U).map(|n| weight(n) * ring(n as f64 / N_U as f64)).sum();
    2.0 * sum / (3.0 * N_U as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_an_ellipsoid_is_that_of_the_closed_forms() {
        assert!((ellipsoid_area([2.0; 3]) - 16.0 * PI).abs() < 1e-9);
        // Prolate, by its closed form: 2πa² (1 + c / (a e) asin e).
        let (a, c) = (1.0_f64, 2.5_f64);
        let e = (1.0 - a * a / (c * c)).sqrt();
        let closed = TAU * a * a * (1.0 + c / (a * e) * e.asin());
        for axes in [[a, a, c], [a, c, a], [c, a, a]] {
            assert!((ellipsoid_area(axes) - closed).abs() < 1e-7, "{axes:?}");
        }
    }
}
