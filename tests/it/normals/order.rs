//! The same bytes however the work is cut, in memory and in files.

use mcubes::geom::{Affine, Grid, Space};
use mcubes::kernel::{Classify, Cpu, Method, Rule};
use mcubes::pipeline::{RunOptions, SurfaceOptions};
use mcubes::volume::{Rescale, Side};
use ndarray::Array3;
use proptest::prelude::*;

use super::{Found, by_kernel, dims_of, mesh_by, uneven};
use crate::support::random::Random;
use crate::surface::wild_f32;

fn size() -> impl Strategy<Value = (usize, usize, usize)> {
    let n = || prop_oneof![5 => 1..7usize, 1 => Just(1usize)];
    let nx = prop_oneof![3 => 1..9usize, 1 => 62..68usize];
    (n(), n(), nx)
}

pub(super) fn volume<T: Clone + std::fmt::Debug>(
    sample: impl Strategy<Value = T> + Clone,
) -> impl Strategy<Value = Array3<T>> {
    size().prop_flat_map(move |(nz, ny, nx)| {
        proptest::collection::vec(sample.clone(), nz * ny * nx)
            .prop_map(move |v| Array3::from_shape_vec((nz, ny, nx), v).unwrap())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_slabs_threads_and_instructions_give_the_same_bytes(
        v in volume(-30i16..=30), slab in 1..5usize, open: bool, gap in 0.5f64..2.0,
        tetrahedra: bool
    ) {
        let method = if tetrahedra { Method::Tetrahedra } else { Method::Cubes };
        let even = Grid::new(dims_of(&v.view()), Affine::IDENTITY);
        let odd = uneven(&even, |k| [1.0, gap][k as usize % 2], |k| 0.01 * k as f64);
        let surface = SurfaceOptions { method, open, ..SurfaceOptions::at(0.5) };
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
            let rule = Rule { iso: 0.5, side: Side::AtLeast, method, open };
            for cpu in [Cpu::Scalar, Cpu::Sse2, Cpu::Avx2, Cpu::Avx512] {
                let found = bits(by_kernel(v.view(), place, Rescale::IDENTITY, rule, cpu));
                prop_assert_eq!(&found, &expected, "{:?}", cpu);
            }
        }
    }
}

/// Positions and normals, as bits.
fn found_by<T: Classify>(v: &Array3<T>, iso: f64, side: Side, cpu: Cpu) -> [Vec<[u32; 3]>; 2] {
    let grid = Grid::new(dims_of(&v.view()), Affine::IDENTITY);
    let rule = Rule { iso, side, method: Method::Cubes, open: false };
    let (vertices, normals) =
        by_kernel(v.view(), (&grid, Space::Ras), Rescale::IDENTITY, rule, cpu);
    [vertices, normals].map(|points| points.iter().map(|p| p.map(f32::to_bits)).collect())
}

/// The same bits as integers of every type.
fn integers_are_the_same_by_all_instructions(v: &Array3<u32>) {
    is_the_same_by_all_instructions(&v.mapv(|x| x as u8), 127.5);
    is_the_same_by_all_instructions(&v.mapv(|x| x as i8), 0.5);
    is_the_same_by_all_instructions(&v.mapv(|x| x as u16), 32_768.0);
    is_the_same_by_all_instructions(&v.mapv(|x| x as i16), -0.5);
    is_the_same_by_all_instructions(v, 2_147_483_648.0);
    is_the_same_by_all_instructions(&v.mapv(|x| x as i32), 0.0);
}

fn is_the_same_by_all_instructions<T: Classify>(v: &Array3<T>, iso: f64) {
    for side in [Side::AtLeast, Side::Below] {
        let expected = found_by(v, iso, side, Cpu::Scalar);
        for cpu in [Cpu::Sse2, Cpu::Avx2, Cpu::Avx512] {
            assert_eq!(found_by(v, iso, side, cpu), expected, "{:?} {side:?} {cpu:?}", T::TYPE);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_whole_range_of_every_type_gives_the_same_bytes_by_all_instructions(
        v in volume(any::<u32>()), wild in volume(wild_f32())
    ) {
        integers_are_the_same_by_all_instructions(&v);
        is_the_same_by_all_instructions(&wild, 0.0);
        is_the_same_by_all_instructions(&wild.mapv(|x| f64::from(x) * 1e200), 0.0);
    }
}

/// More edges of each family in a layer than are gathered at once, and more than one row of words.
#[test]
fn dense_planes_of_every_type_give_the_same_bytes_by_all_instructions() {
    let mut random = Random::new(5);
    let v = Array3::from_shape_fn((4, 71, 130), |_| random.below(1 << 32) as u32);
    integers_are_the_same_by_all_instructions(&v);
    is_the_same_by_all_instructions(&v.mapv(|x| x as i32 as f32), 0.5);
    is_the_same_by_all_instructions(&v.mapv(|x| f64::from(x as i32)), 0.5);
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

#[test]
fn dense_noise_has_the_same_normals_in_a_file_as_in_memory() {
    // More triangles a slab than a patch may have, so that slabs are cut up.
    let mut random = Random::new(7);
    let v = Array3::from_shape_fn((40, 70, 70), |_| random.below(256) as u8);
    let grid = Grid::new(dims_of(&v.view()), Affine::IDENTITY);
    let surface = SurfaceOptions::at(127.5);
    let (vertices, normals) = mesh_by(v.view(), (&grid, Space::Ras), &surface, 2, None);
    let folder = tempfile::tempdir().unwrap();
    let (raw, out) = (folder.path().join("noise.raw"), folder.path().join("noise.ply"));
    std::fs::write(&raw, v.as_slice().unwrap()).unwrap();
    for threads in ["1", "2", "7"] {
        let mut command = assert_cmd::Command::cargo_bin("mcubes").unwrap();
        command.arg(&raw).args(["--dims", "70x70x40", "--type", "u8", "--iso", "127.5", "-q"]);
        command.args(["--normals", "--threads", threads, "-o"]).arg(&out).assert().success();
        let mesh = mcubes::reader::read(&out).unwrap();
        assert!(mesh.vertices == vertices && mesh.normals == normals, "{threads} threads");
    }
}
