//! On any samples.

use mcubes::kernel::Method;
use mcubes::pipeline::SurfaceOptions;
use mcubes::volume::Side;
use ndarray::Array3;
use proptest::prelude::*;

use super::order::volume;
use super::{Found, Point, angle, dot, in_voxels};

/// The definition, on its own: a vertex's normal in voxel space from the samples, and the angle by
/// which `f32` may miss it. Nothing where the gradient is not finite; two where rounding decides
/// whether it leads against its edge.
fn defined(v: &Array3<f64>, low: [usize; 3], axis: usize, iso: f64) -> Vec<(Point, f64)> {
    let at = |p: [usize; 3]| v[(p[2], p[1], p[0])];
    let n = [v.dim().2, v.dim().1, v.dim().0];
    let gradient = |p: [usize; 3]| -> Point {
        [0, 1, 2].map(|a| {
            let (mut q, mut r) = (p, p);
            q[a] = p[a].saturating_sub(1);
            r[a] = (p[a] + 1).min(n[a] - 1);
            if q[a] == r[a] { 0.0 } else { (at(r) - at(q)) / (r[a] - q[a]) as f64 }
        })
    };
    let mut high = low;
    high[axis] += 1;
    let (a, b) = (at(low), at(high));
    let t = ((iso - a) / (b - a)).clamp(1.0 / 1024.0, 1023.0 / 1024.0);
    let (g, h) = (gradient(low), gradient(high));
    let mixed = [0, 1, 2].map(|i| (1.0 - t) * g[i] + t * h[i]);
    let along = mixed[axis];
    let square = dot(mixed, mixed) - along * along;
    let mut turned = mixed;
    turned[axis] = b - a;
    let against = if along * (b - a).signum() < 0.0 { 16.0 * along * along } else { 0.0 };
    let near = 1e-5 * square;
    let mut found = Vec::new();
    if against <= square + near {
        found.push(mixed);
    }
    if against > square - near && against > 0.0 {
        found.push(turned);
    }
    found.retain(|d| d.iter().all(|x| x.is_finite()) && *d != [0.0; 3]);
    // t, 1 - t, two products and their sum are each wrong by half a unit in the last place of the
    // largest slope, of which less may be left.
    let largest = g.iter().chain(&h).fold(0f64, |most, x| most.max(x.abs()));
    let with_error = |d: Point| {
        let unit = f64::from(f32::EPSILON) / 2.0;
        (d.map(|x| -x), 1e-6 + 8.0 * unit * largest / dot(d, d).sqrt())
    };
    found.into_iter().map(with_error).collect()
}

/// Holds every normal of a volume, in voxel space, against the definition; where that has none,
/// against the edge. `inside` and `iso` as the surface has them.
fn check(v: &Array3<f64>, (vertices, normals): &Found, inside: impl Fn(f64) -> bool, below: bool) {
    let n = [v.dim().2, v.dim().1, v.dim().0];
    assert_eq!(vertices.len(), normals.len());
    for (p, normal) in vertices.iter().zip(normals) {
        let length = dot(normal.map(f64::from), normal.map(f64::from)).sqrt();
        assert!((length - 1.0).abs() < 1e-6, "{normal:?} at {p:?}");
        let broken: Vec<usize> = (0..3).filter(|&a| p[a].fract() != 0.0).collect();
        let [axis] = broken[..] else {
            assert_eq!(broken.len(), 3, "inside a cell");
            continue;
        };
        let mut outward = [0.0; 3];
        if p[axis] < 0.0 || p[axis] > n[axis] as f32 - 1.0 {
            outward[axis] = f64::from(p[axis].signum());
            assert_eq!(normal.map(f64::from), outward, "the cap at {p:?}");
            continue;
        }
        let low = p.map(|x| x as usize);
        let a = v[(low[2], low[1], low[0])];
        outward[axis] = if inside(a) { 1.0 } else { -1.0 };
        // Never more than 14 degrees against the edge.
        assert!(dot(normal.map(f64::from), outward) > -0.25, "{normal:?} at {p:?}");
        let mut expected = defined(v, low, axis, 0.0);
        if below {
            for (d, _) in &mut expected {
                *d = d.map(|x| -x);
            }
        }
        if expected.is_empty() {
            expected.push((outward, 1e-6));
        }
        let is_one = expected.iter().any(|&(d, error)| angle(*normal, d) < error);
        assert!(is_one, "{normal:?}, {expected:?} at {p:?}");
    }
}

/// Numbers of every kind.
fn wild() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        4 => -1.0f64..1.0,
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(1.0)],
        1 => Just(f64::NAN),
        1 => prop_oneof![Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
        1 => prop_oneof![Just(1.7e308), Just(-1.7e308), Just(1e-310), Just(-1e-310), Just(5e-324)],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn of_noise_they_are_by_the_definition(v in volume(-40i16..=40)) {
        let wide = v.mapv(|x| f64::from(x) - 0.25);
        for side in [Side::AtLeast, Side::Below] {
            let surface = SurfaceOptions { side, ..SurfaceOptions::at(0.25) };
            let below = side == Side::Below;
            check(&wide, &in_voxels(v.view(), &surface), |x| (x >= 0.0) != below, below);
        }
    }

    #[test]
    fn of_plateaus_they_are_by_the_definition(v in volume(0u8..=1)) {
        let wide = v.mapv(|x| f64::from(x) - 0.5);
        check(&wide, &in_voxels(v.view(), &SurfaceOptions::at(0.5)), |x| x >= 0.0, false);
    }

    #[test]
    fn of_anything_at_all_they_have_length_1_and_point_outward(v in volume(wild())) {
        for (side, method) in [
            (Side::AtLeast, Method::Cubes),
            (Side::Below, Method::Cubes),
            (Side::AtLeast, Method::Tetrahedra),
        ] {
            let surface = SurfaceOptions { side, method, ..SurfaceOptions::at(0.0) };
            let (vertices, normals) = in_voxels(v.view(), &surface);
            for (p, n) in vertices.iter().zip(&normals) {
                let length = dot(n.map(f64::from), n.map(f64::from)).sqrt();
                prop_assert!((length - 1.0).abs() < 1e-6, "{:?} at {:?}", n, p);
                let broken: Vec<usize> = (0..3).filter(|&a| p[a].fract() != 0.0).collect();
                let last = [v.dim().2, v.dim().1, v.dim().0].map(|n| n as f32 - 1.0);
                if let [axis] = broken[..] && p[axis] > 0.0 && p[axis] < last[axis] {
                    let low = p.map(|x| x as usize);
                    let a = v[(low[2], low[1], low[0])];
                    let is_inside = if side == Side::AtLeast { a >= 0.0 } else { a < 0.0 };
                    let outward = if is_inside { n[axis] } else { -n[axis] };
                    prop_assert!(outward > -0.25, "{:?} at {:?}", n, p);
                }
            }
        }
    }
}
