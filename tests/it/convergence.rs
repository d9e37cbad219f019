//! On smooth shapes the error of the mesh goes down by four where the spacing halves.

use std::f64::consts::PI;

use mcubes::mesh::Measure;
use mcubes::pipeline::{Method, RunOptions, SurfaceOptions};
use ndarray::Array3;

type Point = [f64; 3];

const METHODS: [Method; 2] = [Method::Cubes, Method::Tetrahedra];

/// What is measured of a mesh, in the shape's own units.
#[derive(Debug)]
struct Found {
    area: f64,
    volume: f64,
    /// The largest distance of a vertex from the surface.
    off: f64,
}

/// Meshes `f` ≥ 0 by a method with `n` steps along the edge of the cube [low, low + edge]³. `distance` is that
/// of a point from the surface.
fn found(
    method: Method,
    (low, edge, n, open): (f64, f64, usize, bool),
    f: impl Fn(Point) -> f64,
    distance: impl Fn(Point) -> f64,
) -> Found {
    let step = edge / n as f64;
    let place = |p: Point| p.map(|x| low + step * x);
    let volume = Array3::from_shape_fn((n + 1, n + 1, n + 1), |(z, y, x)| {
        f(place([x, y, z].map(|x| x as f64)))
    });
    let surface = SurfaceOptions { method, open, ..SurfaceOptions::at(0.0) };
    let mesh = mcubes::mesh(volume.view(), &surface, &RunOptions::default()).unwrap();
    let (vertices, triangles) = (mesh.vertices.to_vec(), mesh.triangles.to_vec());
    let mut measure = Measure::default();
    for t in &triangles {
        measure.add(t.map(|id| vertices[id as usize]));
    }
    let off = vertices.iter().map(|v| distance(place(v.map(f64::from))).abs()).fold(0.0, f64::max);
    Found { area: measure.area * step.powi(2), volume: measure.volume * step.powi(3), off }
}

fn assert_quartered(errors: [f64; 3], what: &str) {
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((3.0..5.5).contains(&ratio), "{what}: {errors:?}");
    }
}

fn assert_converges(shapes: &[Found; 3], area: f64, volume: f64, what: &str) {
    let errors = |f: &dyn Fn(&Found) -> f64| [0, 1, 2].map(|k| f(&shapes[k]).abs());
    assert_quartered(errors(&|s| s.area - area), &format!("{what}: area"));
    assert_quartered(errors(&|s| s.volume - volume), &format!("{what}: volume"));
    assert_quartered(errors(&|s| s.off), &format!("{what}: distance"));
}

#[test]
fn a_sphere_converges_with_the_square_of_the_spacing() {
    let distance = |p: Point| 1.0 - p.iter().map(|x| (x - 0.013).powi(2)).sum::<f64>().sqrt();
    // Not the distance itself, which is nearly linear along an edge.
    let f = |p: Point| 1.0 - (1.0 - distance(p)).powi(2);
    for method in METHODS {
        let shapes = [16, 32, 64].map(|n| found(method, (-1.31, 2.62, n, false), f, distance));
        assert_converges(&shapes, 4.0 * PI, 4.0 / 3.0 * PI, &format!("sphere, {method:?}"));
    }
}

#[test]
fn a_torus_converges_with_the_square_of_the_spacing() {
    let (ring, tube) = (0.81, 0.37);
    let from_ring = |[x, y, z]: Point| ((x - 0.011).hypot(y + 0.007) - ring).hypot(z - 0.003);
    let distance = |p: Point| tube - from_ring(p);
    let f = |p: Point| tube * tube - from_ring(p).powi(2);
    let area = 4.0 * PI * PI * ring * tube;
    for method in METHODS {
        let shapes = [24, 48, 96].map(|n| found(method, (-1.31, 2.62, n, false), f, distance));
        assert_converges(&shapes, area, area * tube / 2.0, &format!("torus, {method:?}"));
    }
}

#[test]
fn a_gyroid_converges_with_the_square_of_the_spacing() {
    let f = |[x, y, z]: Point| x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
    // To first order, which is exact in the limit.
    let distance = |[x, y, z]: Point| {
        let slope = [
            x.cos() * y.cos() - z.sin() * x.sin(),
            y.cos() * z.cos() - x.sin() * y.sin(),
            z.cos() * x.cos() - y.sin() * z.sin(),
        ];
        f([x, y, z]) / slope.iter().map(|s| s * s).sum::<f64>().sqrt()
    };
    for method in METHODS {
        let shape = |n| found(method, (0.2, 2.0 * PI, n, true), f, distance);
        let [a, b, c, d] = [12, 24, 48, 96].map(shape);
        // The area of one period has no formula; that of the steps towards it is enough.
        let steps = [a.area - b.area, b.area - c.area, c.area - d.area].map(f64::abs);
        assert_quartered(steps, &format!("gyroid, {method:?}: area"));
        assert_quartered([b.off, c.off, d.off], &format!("gyroid, {method:?}: distance"));
    }
}
