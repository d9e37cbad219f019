//! Normals: those of the formula on smooth shapes, by the definition on any samples, always of
//! length 1 and outward, and the same bytes however the work is cut.

use mcubes::geom::{Affine, Dims, Grid, Place, Space};
use mcubes::kernel::{Classify, Cpu, Kernel, PatchSlices, Rule, Scratch, Side, Slab};
use mcubes::mesh::{Normal, Position};
use mcubes::pipeline::{RunOptions, SurfaceOptions};
use mcubes::volume::Rescale;
use ndarray::{Array3, ArrayView3};
use proptest::prelude::*;

type Point = [f64; 3];

/// Vertices with their normals.
type Found = (Vec<Position>, Vec<Normal>);

fn dims_of<T>(volume: &ArrayView3<'_, T>) -> Dims {
    let (nz, ny, nx) = volume.dim();
    Dims::checked(nx as i64, ny as i64, nz as i64, 8).unwrap()
}

fn mesh_by<T: Classify>(
    volume: ArrayView3<'_, T>,
    (grid, space): (&Grid, Space),
    surface: &SurfaceOptions,
    threads: usize,
    slab_planes: Option<usize>,
) -> Found {
    let surface = SurfaceOptions { normals: true, ..*surface };
    let options = RunOptions { threads, slab_planes, ..RunOptions::default() };
    let mesh = mcubes::mesh_placed(volume, grid, space, &surface, &options).unwrap();
    (mesh.vertices.to_vec(), mesh.normals.unwrap().to_vec())
}

fn in_voxels<T: Classify>(volume: ArrayView3<'_, T>, surface: &SurfaceOptions) -> Found {
    let grid = Grid::new(dims_of(&volume), Affine::IDENTITY);
    mesh_by(volume, (&grid, Space::Voxel), surface, 1, None)
}

/// The whole volume as one slab.
fn by_kernel<T: Classify>(
    volume: ArrayView3<'_, T>,
    (grid, space): (&Grid, Space),
    rescale: Rescale,
    rule: Rule,
    cpu: Cpu,
) -> Found {
    let (nz, ny, nx) = volume.dim();
    let place = Place::new(grid, space).unwrap();
    let kernel = Kernel::new(grid.dims, &place, rescale, rule, cpu);
    let samples = volume.as_slice().unwrap();
    let planes: Vec<&[T]> = samples.chunks_exact(nx * ny).collect();
    let slab = Slab { layers: 0..nz + 1, first_plane: 0, planes: &planes };
    let mut scratch = Scratch::default();
    let totals = kernel.count(&slab, &mut scratch);
    let mut vertices = vec![[0.0; 3]; totals.n_vertices as usize];
    let mut normals = vec![[0.0; 3]; totals.n_vertices as usize];
    let mut triangles = vec![[0; 3]; totals.n_triangles as usize];
    let out = PatchSlices {
        ghosts: None,
        vertices: &mut vertices,
        normals: Some(&mut normals),
        triangles: &mut triangles,
    };
    kernel.fill(&slab, &scratch, 0..nz + 1, 0, out);
    (vertices, normals)
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: Point) -> Point {
    v.map(|x| x / dot(v, v).sqrt())
}

/// The angle between a normal and a direction, in radians: by the chord, since a cosine near 1
/// tells no small angle.
fn angle(normal: Normal, direction: Point) -> f64 {
    let (a, b) = (unit(normal.map(f64::from)), unit(direction));
    let chord = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    2.0 * (dot(chord, chord).sqrt() / 2.0).min(1.0).asin()
}

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
        for (side, sign) in [(Side::AtLeast, 1.0), (Side::Below, -1.0)] {
            // Inside out, the outside of the box is inside no more: only the hole's wall counts.
            let surface = SurfaceOptions { side, open: true, ..SurfaceOptions::at(0.0) };
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
    let rule = Rule { iso: 7.0, side: Side::AtLeast, open: true };
    for (slope, inter) in [(2.0, 7.0), (-2.0, 7.0)] {
        let stored = ball.mapv(|x| x / slope);
        let rescale = Rescale::new(slope, inter).unwrap();
        let found = by_kernel(stored.view(), (&grid, Space::Ras), rescale, rule, Cpu::Scalar);
        assert_exact(&found, from_centre, "rescaled");
    }
}

/// The same grid with other gaps between its planes, along the true line of its planes.
fn uneven(grid: &Grid, gap: impl Fn(i64) -> f64, aside: impl Fn(i64) -> f64) -> Grid {
    let nz = grid.dims.nz() as i64;
    let step = grid.affine.column(2);
    let mut at = -(0..nz).map(&gap).sum::<f64>() / 2.0 + (nz - 1) as f64 / 2.0;
    let mut origins = Vec::new();
    for k in 0..nz {
        let mut origin = [0, 1, 2].map(|a| grid.affine.column(3)[a] + at * step[a]);
        origin[0] += aside(k);
        origins.push(origin);
        at += gap(k);
    }
    Grid::uneven(grid.dims, grid.affine, origins)
}

#[test]
fn between_uneven_planes_the_true_distances_count() {
    for (what, grid) in places() {
        let gaps = [0.5, 1.3, 0.8, 1.6];
        let grid = uneven(&grid, |k| gaps[k as usize % 4], |_| 0.0);
        let along = unit(grid.affine.column(2));
        let ball = sampled(&grid, |p| 12.25 - dot(from_centre(p), from_centre(p)));
        let found = mesh_by(
            ball.view(),
            (&grid, Space::Ras),
            &SurfaceOptions { open: true, ..SurfaceOptions::at(0.0) },
            1,
            None,
        );
        // Where planes are sheared the samples above and below are not the nearest ones: still
        // exact, since all three lie on one line.
        assert!(along[2] > 0.0);
        assert_exact(&found, from_centre, what);
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

/// The definition, on its own: a vertex's normal in voxel space from the samples, nothing where the
/// gradient is not finite.
fn defined(v: &Array3<f64>, low: [usize; 3], axis: usize, iso: f64) -> Option<Point> {
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
    let mut mixed = [0, 1, 2].map(|i| (1.0 - t) * g[i] + t * h[i]);
    let along = mixed[axis];
    let square = dot(mixed, mixed) - along * along;
    if along * (b - a).signum() < 0.0 && 16.0 * along * along > square {
        mixed[axis] = b - a;
    }
    let is_some = mixed.iter().all(|x| x.is_finite()) && mixed != [0.0; 3];
    is_some.then(|| mixed.map(|x| -x))
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
        let expected = match defined(v, low, axis, 0.0) {
            Some(d) if below => d.map(|x| -x),
            Some(d) => d,
            None => outward,
        };
        // Slopes that differ by more than floats can tell leave the angle as it is.
        let off = angle(*normal, expected);
        assert!(off < 1e-6, "{normal:?}, {expected:?} at {p:?}");
    }
}

fn size() -> impl Strategy<Value = (usize, usize, usize)> {
    let n = || prop_oneof![5 => 1..7usize, 1 => Just(1usize)];
    let nx = prop_oneof![3 => 1..9usize, 1 => 62..68usize];
    (n(), n(), nx)
}

fn volume<T: Clone + std::fmt::Debug>(
    sample: impl Strategy<Value = T> + Clone,
) -> impl Strategy<Value = Array3<T>> {
    size().prop_flat_map(move |(nz, ny, nx)| {
        proptest::collection::vec(sample.clone(), nz * ny * nx)
            .prop_map(move |v| Array3::from_shape_vec((nz, ny, nx), v).unwrap())
    })
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
        for side in [Side::AtLeast, Side::Below] {
            let surface = SurfaceOptions { side, ..SurfaceOptions::at(0.0) };
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

    #[test]
    fn any_slabs_threads_and_instructions_give_the_same_bytes(
        v in volume(-30i16..=30), slab in 1..5usize, open: bool, gap in 0.5f64..2.0
    ) {
        let even = Grid::new(dims_of(&v.view()), Affine::IDENTITY);
        let odd = uneven(&even, |k| [1.0, gap][k as usize % 2], |k| 0.01 * k as f64);
        let surface = SurfaceOptions { open, ..SurfaceOptions::at(0.5) };
        for grid in [even, odd] {
            let place = (&grid, Space::Ras);
            let bits = |(_, normals): Found| -> Vec<[u32; 3]> {
                normals.iter().map(|n| n.map(f32::to_bits)).collect()
            };
            let expected = bits(mesh_by(v.view(), place, &surface, 1, None));
            for threads in [1, 2, 7] {
                let found = bits(mesh_by(v.view(), place, &surface, threads, Some(slab)));
                prop_assert_eq!(&found, &expected);
            }
            let rule = Rule { iso: 0.5, side: Side::AtLeast, open };
            for cpu in [Cpu::Scalar, Cpu::Sse2, Cpu::Avx2, Cpu::Avx512] {
                let found = bits(by_kernel(v.view(), place, Rescale::IDENTITY, rule, cpu));
                prop_assert_eq!(&found, &expected, "{:?}", cpu);
            }
        }
    }
}

#[test]
fn without_them_the_mesh_is_the_same() {
    let v = Array3::from_shape_fn((9, 10, 70), |(z, y, x)| ((x * 7 + y * 13 + z * 29) % 17) as u8);
    let options = RunOptions { threads: 2, slab_planes: Some(2), ..RunOptions::default() };
    let plain = mcubes::mesh(v.view(), &SurfaceOptions::at(8.5), &options).unwrap();
    assert!(plain.normals.is_none());
    let surface = SurfaceOptions { normals: true, ..SurfaceOptions::at(8.5) };
    let more = mcubes::mesh(v.view(), &surface, &options).unwrap();
    assert_eq!(plain.vertices[..], more.vertices[..]);
    assert_eq!(plain.triangles[..], more.triangles[..]);
}
