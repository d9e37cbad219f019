//! The promise, on volumes of every kind: closed, manifold, outward, clean, in place, and the same
//! bytes however the work is cut.

use mcubes::geom::{Affine, Dims, Grid, Place, Space};
use mcubes::kernel::{Classify, Cpu, Kernel, Method, Rule};
use mcubes::mesh::{Position, Triangle};
use mcubes::pipeline::{RunOptions, SurfaceOptions};
use mcubes::volume::{Rescale, Side};
use ndarray::{Array3, ArrayView3};
use proptest::prelude::*;

use crate::support::manifold::{assert_clean, assert_clean_but_open, enclosed};
use crate::support::one_slab::one_slab;

pub(crate) type Mesh = (Vec<Position>, Vec<Triangle>);

pub(crate) fn mesh<T: Classify>(volume: ArrayView3<'_, T>, surface: &SurfaceOptions) -> Mesh {
    mesh_by(volume, surface, 1, None)
}

pub(crate) fn mesh_by<T: Classify>(
    volume: ArrayView3<'_, T>,
    surface: &SurfaceOptions,
    threads: usize,
    slab_planes: Option<usize>,
) -> Mesh {
    let options = RunOptions { threads, slab_planes, ..RunOptions::default() };
    let mesh = mcubes::mesh(volume, surface, &options).unwrap();
    (mesh.vertices.to_vec(), mesh.triangles.to_vec())
}

/// The whole volume as one slab, by one instruction set.
pub(crate) fn mesh_on<T: Classify>(volume: ArrayView3<'_, T>, rule: Rule, cpu: Cpu) -> Mesh {
    let (nz, ny, nx) = volume.dim();
    let dims = Dims::checked(nx as i64, ny as i64, nz as i64, 8).unwrap();
    let place = Place::new(&Grid::new(dims, Affine::IDENTITY), Space::Voxel).unwrap();
    let kernel = Kernel::new(dims, &place, Rescale::IDENTITY, rule, cpu);
    let mesh = one_slab(volume, &kernel, false);
    (mesh.vertices, mesh.triangles)
}

fn dims() -> impl Strategy<Value = (usize, usize, usize)> {
    let n = || prop_oneof![4 => 1..7usize, 1 => Just(1usize)];
    // Widths around the words of a bit plane.
    let nx = prop_oneof![3 => 1..9usize, 2 => 60..70usize, 1 => 126..131usize, 1 => 510..515usize];
    (n(), n(), nx)
}

pub(crate) fn volume<T: Clone + std::fmt::Debug>(
    sample: impl Strategy<Value = T> + Clone,
) -> impl Strategy<Value = Array3<T>> {
    dims().prop_flat_map(move |(nz, ny, nx)| {
        proptest::collection::vec(sample.clone(), nz * ny * nx)
            .prop_map(move |v| Array3::from_shape_vec((nz, ny, nx), v).unwrap())
    })
}

pub(crate) fn wild_f32() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![
        4 => -1.0f32..1.0,
        1 => Just(0.0f32),
        1 => Just(-0.0f32),
        1 => Just(f32::NAN),
        1 => prop_oneof![Just(f32::INFINITY), Just(f32::NEG_INFINITY)],
        1 => prop_oneof![Just(3e38f32), Just(-3e38f32), Just(1e-42f32)],
    ]
}

pub(crate) fn check<T: Classify>(volume: &Array3<T>, method: Method, inside: impl Fn(T) -> bool) {
    for side in [Side::AtLeast, Side::Below] {
        let surface = SurfaceOptions { side, method, ..SurfaceOptions::at(0.0) };
        let (vertices, triangles) = mesh(volume.view(), &surface);
        assert_clean(&vertices, &triangles, "closed");
        let any = volume
            .iter()
            .any(|&v| (side == Side::AtLeast) == inside(v) && v.partial_cmp(&v).is_some());
        assert_eq!(any, !triangles.is_empty());
        if any {
            assert!(enclosed(&vertices, &triangles) > 0.0, "wound outward");
        }
        let open = SurfaceOptions { open: true, ..surface };
        let (vertices, triangles) = mesh(volume.view(), &open);
        assert_clean_but_open(&vertices, &triangles, "open");
        let (nz, ny, nx) = volume.dim();
        for v in vertices {
            for (x, n) in v.into_iter().zip([nx, ny, nz]) {
                assert!(x >= 0.0 && x <= n as f32 - 1.0, "{v:?} lies between samples");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn noise_is_closed_manifold_and_outward(v in volume(wild_f32())) {
        check(&v, Method::Cubes, |x| x >= 0.0);
    }

    #[test]
    fn plateaus_at_the_iso_value_are_closed_manifold_and_outward(v in volume(-1i16..=1)) {
        check(&v, Method::Cubes, |x| x >= 0);
    }

    #[test]
    fn any_slabs_threads_and_instructions_give_the_same_bytes(
        v in volume(-2i16..=2), slab in 1..5usize, open: bool
    ) {
        let surface = SurfaceOptions { open, ..SurfaceOptions::at(0.5) };
        let expected = mesh(v.view(), &surface);
        for threads in [1, 2, 7] {
            prop_assert_eq!(&mesh_by(v.view(), &surface, threads, Some(slab)), &expected);
        }
        let rule = Rule { iso: 0.5, side: Side::AtLeast, method: Method::Cubes, open };
        for cpu in [Cpu::Scalar, Cpu::Sse2, Cpu::Avx2, Cpu::Avx512] {
            prop_assert_eq!(&mesh_on(v.view(), rule, cpu), &expected, "{:?}", cpu);
        }
    }

    #[test]
    fn all_types_are_told_inside_from_outside_by_all_instructions(v in volume(0u8..=255), iso in 0..=255u8) {
        let signed = v.mapv(|x| (x as i8).wrapping_sub(-128));
        for side in [Side::AtLeast, Side::Below] {
            let rule = |iso: f64| Rule { iso, side, method: Method::Cubes, open: false };
            let expected = mesh_on(v.view(), rule(f64::from(iso)), Cpu::Scalar);
            for cpu in [Cpu::Sse2, Cpu::Avx2, Cpu::Avx512] {
                let iso = f64::from(iso);
                prop_assert_eq!(&mesh_on(v.view(), rule(iso), cpu), &expected);
                prop_assert_eq!(&mesh_on(signed.view(), rule(iso - 128.0), cpu), &expected);
                prop_assert_eq!(&mesh_on(v.mapv(u16::from).view(), rule(iso), cpu), &expected);
                prop_assert_eq!(&mesh_on(v.mapv(i16::from).view(), rule(iso), cpu), &expected);
                prop_assert_eq!(&mesh_on(v.mapv(u32::from).view(), rule(iso), cpu), &expected);
                prop_assert_eq!(&mesh_on(v.mapv(i32::from).view(), rule(iso), cpu), &expected);
                prop_assert_eq!(&mesh_on(v.mapv(f32::from).view(), rule(iso), cpu), &expected);
                prop_assert_eq!(&mesh_on(v.mapv(f64::from).view(), rule(iso), cpu), &expected);
            }
        }
    }

    #[test]
    fn there_is_one_vertex_for_each_grid_edge_whose_ends_differ(v in volume(-3i16..=3)) {
        let (vertices, _) = mesh(v.view(), &SurfaceOptions::at(0.25));
        let expected = crossings(&v, 0.25, &[[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        // Beside these only vertices inside cells, none of whose coordinates is whole.
        let on_edges: std::collections::HashSet<[u32; 3]> = vertices
            .iter()
            .filter(|v| v.iter().filter(|x| x.fract() == 0.0).count() == 2)
            .map(|v| v.map(|x| (x + 0.0).to_bits()))
            .collect();
        let inner = vertices.iter().filter(|v| v.iter().all(|x| x.fract() != 0.0)).count();
        prop_assert_eq!(on_edges.len() + inner, vertices.len());
        prop_assert_eq!(on_edges, expected);
    }
}

/// The points of the volume with its border on edges of the given steps whose ends differ, where
/// the value is reached: the definition, by brute force.
pub(crate) fn crossings(
    v: &Array3<i16>,
    iso: f64,
    edges: &[[i64; 3]],
) -> std::collections::HashSet<[u32; 3]> {
    let (nz, ny, nx) = v.dim();
    let epsilon = 1.0 / 1024.0;
    let at = |p: [i64; 3]| {
        let [x, y, z] = p.map(|x| usize::try_from(x).ok());
        v.get((z?, y?, x?)).map(|&s| f64::from(s))
    };
    let mut found = std::collections::HashSet::new();
    for z in -1..=nz as i64 {
        for y in -1..=ny as i64 {
            for x in -1..=nx as i64 {
                for step in edges {
                    let low = [x, y, z];
                    let high = [0, 1, 2].map(|axis| low[axis] + step[axis]);
                    let (a, b) = (at(low), at(high));
                    let inside = |s: Option<f64>| s.is_some_and(|s| s >= iso);
                    if inside(a) == inside(b) {
                        continue;
                    }
                    let t = match (a, b) {
                        (Some(a), Some(b)) => ((iso - a) / (b - a)).clamp(epsilon, 1.0 - epsilon),
                        (None, _) => 1.0 - epsilon,
                        (_, None) => epsilon,
                    };
                    let p = [0, 1, 2].map(|axis| low[axis] as f64 + t * step[axis] as f64);
                    found.insert(p.map(|x| (x as f32 + 0.0).to_bits()));
                }
            }
        }
    }
    found
}

#[test]
fn all_256_cells_and_all_pairs_of_cells_are_closed_and_manifold() {
    for bits in 0..4096u32 {
        let pair = Array3::from_shape_fn((2, 2, 3), |(z, y, x)| {
            f32::from((bits >> (x + 3 * y + 6 * z) & 1) as u8) - 0.5
        });
        for turned in
            [pair.view(), pair.view().permuted_axes([0, 2, 1]), pair.view().reversed_axes()]
        {
            let (vertices, triangles) = mesh(turned, &SurfaceOptions::at(0.0));
            assert_clean(&vertices, &triangles, &format!("cells {bits:#x}"));
        }
    }
}

#[test]
fn a_volume_that_is_all_inside_is_a_closed_box_and_open_it_is_nothing() {
    let full = Array3::<u8>::from_elem((3, 4, 5), 9);
    let (vertices, triangles) = mesh(full.view(), &SurfaceOptions::at(5.0));
    assert_clean(&vertices, &triangles, "box");
    assert_eq!(vertices.len() + triangles.len() - triangles.len() * 3 / 2, 2);
    let side = |n: f64| n - 1.0 + 2.0 / 1024.0;
    let most = side(3.0) * side(4.0) * side(5.0);
    let volume = enclosed(&vertices, &triangles);
    assert!(volume > 2.0 * 3.0 * 4.0 && volume < most, "{volume}");
    let open = SurfaceOptions { open: true, ..SurfaceOptions::at(5.0) };
    assert_eq!(mesh(full.view(), &open).1.len(), 0);
}
