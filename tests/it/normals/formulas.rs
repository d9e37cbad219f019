//! On shapes with a formula.

use mcubes::geom::{Affine, Dims, Grid, Space};
use mcubes::kernel::{Cpu, Method, Rule};
use mcubes::pipeline::SurfaceOptions;
use mcubes::volume::{Rescale, Side};
use ndarray::Array3;

use super::{Found, Point, angle, by_kernel, dot, mesh_by, uneven};

/// The centre of the shapes below, in millimetres, off every grid.
const CENTRE: Point = [0.31, -0.17, 0.23];

fn from_centre(p: Point) -> Point {
    [p[0] - CENTRE[0], p[1] - CENTRE[1], p[2] - CENTRE[2]]
}

/// Samples a function of millimetres on a grid.
fn sampled(grid: &Grid, f: impl Fn(Point) -> f64) -> Array3<f64> {
    let [nx, ny, nz] = grid.dims.to_array();
    let (ci, cj) = (grid.affine.column(0), grid.affine.column(1));
    Array3::from_shape_fn((nz, ny, nx), |(k, j, i)| {
        let origin = grid.plane_origin(k as i64);
        f([0, 1, 2].map(|a| origin[a] + i as f64 * ci[a] + j as f64 * cj[a]))
    })
}

/// A grid around the origin.
fn grid(dims: [i64; 3], columns: [Point; 3]) -> Grid {
    let [i, j, k] = columns;
    let half = dims.map(|n| -(n - 1) as f64 / 2.0);
    let origin = [0, 1, 2].map(|a| half[0] * i[a] + half[1] * j[a] + half[2] * k[a]);
    let dims = Dims::checked(dims[0], dims[1], dims[2], 8).unwrap();
    Grid::new(dims, Affine::from_columns(i, j, k, origin))
}

#[test]
fn on_a_sphere_they_converge_with_the_square_of_the_spacing() {
    let radius = 20.0;
    // Far from linear: the third derivative is 6 / r^4 where the first is 1 / r^2. So the central
    // difference is off by (h / r)^2 of itself, and its linear interpolation by 6/8 of that.
    let field = |p: Point| 1.0 / dot(from_centre(p), from_centre(p)).sqrt() - 1.0 / radius;
    let mut worst = [0.0; 3];
    for (n, worst) in worst.iter_mut().enumerate() {
        let by = 2f64.powi(-(n as i32));
        let spacing = [0.5 * by, 0.7 * by, 2.0 * by];
        let dims = spacing.map(|s| (48.0 / s) as i64);
        let [x, y, z] = spacing;
        let grid = grid(dims, [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
        let volume = sampled(&grid, field).mapv(|x| x as f32);
        let surface = SurfaceOptions::at(0.0);
        let (vertices, normals) = mesh_by(volume.view(), (&grid, Space::Ras), &surface, 2, None);
        for (v, n) in vertices.iter().zip(&normals) {
            *worst = angle(*n, from_centre(v.map(f64::from))).max(*worst);
        }
        let bound = 1.75 * (z / radius).powi(2);
        assert!(*worst < bound, "spacing {spacing:?}: {worst} radians, {bound} at most");
    }
    for pair in worst.windows(2) {
        assert!((3.0..5.5).contains(&(pair[0] / pair[1])), "{worst:?}");
    }
}

/// Ways in which samples may lie in space; the steps along i, j, k.
fn places() -> Vec<(&'static str, Grid)> {
    let dims = [24, 26, 22];
    vec![
        ("straight", grid(dims, [[0.5, 0.0, 0.0], [0.0, 0.7, 0.0], [0.0, 0.0, 1.0]])),
        ("mirrored", grid(dims, [[-0.5, 0.0, 0.0], [0.0, 0.7, 0.0], [0.0, 0.0, 1.0]])),
        ("oblique", grid(dims, [[0.4, 0.3, -0.1], [-0.35, 0.5, 0.2], [0.2, -0.1, 0.9]])),
        ("sheared", grid(dims, [[0.6, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.45, 0.8]])),
        ("turned inside out", grid(dims, [[0.1, 0.6, 0.0], [0.7, -0.1, 0.1], [0.05, 0.2, 0.8]])),
    ]
}

/// The gradient of a quadratic is linear: central differences and linear interpolation give it
/// exactly, so a normal is what the formula has at the vertex, but for the rounding of positions.
fn assert_exact((vertices, normals): &Found, direction: impl Fn(Point) -> Point, what: &str) {
    assert!(vertices.len() > 300 && vertices.len() == normals.len(), "{what}");
    for (v, n) in vertices.iter().zip(normals) {
        let off = angle(*n, direction(v.map(f64::from)));
        assert!(off < 2e-6, "{what}: {off} radians at {v:?}");
    }
}

#[test]
fn wherever_the_samples_lie_they_are_those_of_the_formula() {
    for (what, grid) in places() {
        let ball = sampled(&grid, |p| 12.25 - dot(from_centre(p), from_centre(p)));
        let lps = |p: Point| [-p[0], -p[1], p[2]];
        let sides = [(Side::AtLeast, 1.0), (Side::Below, -1.0)];
        let methods = [Method::Cubes, Method::Tetrahedra];
        for ((side, sign), method) in sides.into_iter().flat_map(|s| methods.map(|m| (s, m))) {
            // Inside out, the outside of the box is inside no more: only the hole's wall counts.
            let surface = SurfaceOptions { side, method, open: true, ..SurfaceOptions::at(0.0) };
            let found = mesh_by(ball.view(), (&grid, Space::Ras), &surface, 1, None);
            assert_exact(&found, |p| from_centre(p).map(|x| sign * x), what);
            let found = mesh_by(ball.view(), (&grid, Space::Lps), &surface, 1, None);
            assert_exact(&found, |p| lps(from_centre(lps(p))).map(|x| sign * x), what);
            // In voxels the direction is the transpose's image of that in millimetres.
            let found = mesh_by(ball.view(), (&grid, Space::Voxel), &surface, 1, None);
            let turned = |p: Point| {
                let d = from_centre(grid.affine.apply(p));
                [0, 1, 2].map(|c| sign * dot(grid.affine.column(c), d))
            };
            assert_exact(&found, turned, what);
        }
    }
}

#[test]
fn a_negative_slope_turns_nothing() {
    let (_, grid) = places().remove(2);
    let ball = sampled(&grid, |p| 12.25 - dot(from_centre(p), from_centre(p)));
    let rule = Rule { iso: 7.0, side: Side::AtLeast, method: Method::Cubes, open: true };
    for (slope, inter) in [(2.0, 7.0), (-2.0, 7.0)] {
        let stored = ball.mapv(|x| x / slope);
        let rescale = Rescale::new(slope, inter).unwrap();
        let found = by_kernel(stored.view(), (&grid, Space::Ras), rescale, rule, Cpu::Scalar);
        assert_exact(&found, from_centre, "rescaled");
    }
}

#[test]
fn between_uneven_planes_the_true_distances_count() {
    for (what, grid) in places() {
        let gaps = [0.5, 1.3, 0.8, 1.6];
        let grid = uneven(&grid, |k| gaps[k as usize % 4], |_| 0.0);
        let ball = sampled(&grid, |p| 12.25 - dot(from_centre(p), from_centre(p)));
        for method in [Method::Cubes, Method::Tetrahedra] {
            let surface = SurfaceOptions { method, open: true, ..SurfaceOptions::at(0.0) };
            let found = mesh_by(ball.view(), (&grid, Space::Ras), &surface, 1, None);
            assert_exact(&found, from_centre, what);
        }
    }
}

#[test]
fn planes_that_are_shifted_sideways_too_are_near_the_formula() {
    let (_, grid) = places().remove(0);
    let grid = uneven(&grid, |k| [0.7, 1.2][k as usize % 2], |k| [0.0, 0.1, -0.05][k as usize % 3]);
    let ball = sampled(&grid, |p| 12.25 - dot(from_centre(p), from_centre(p)));
    let surface = SurfaceOptions { open: true, ..SurfaceOptions::at(0.0) };
    let (vertices, normals) = mesh_by(ball.view(), (&grid, Space::Ras), &surface, 1, None);
    for (v, n) in vertices.iter().zip(&normals) {
        // A shift of u between planes h apart leaves u^2 / h of the curvature in the slope.
        let off = angle(*n, from_centre(v.map(f64::from)));
        assert!(off < 0.15 * 0.15 / 0.7 / 3.5 + 1e-6, "{off} radians at {v:?}");
    }
}
