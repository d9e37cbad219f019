//! `formula`: the values of a function of millimetres.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::Duration;

use mcubes::error::{Failure, Kind};
use mcubes::geom::{Affine, Dims, Place, Space};
use mcubes::pipeline::{RunOptions, SurfaceOptions, extract};
use mcubes::sink::{MeshFile, MeshFormat, MeshOptions, Sink};
use mcubes::source::{crop, formula};

use super::sources::{Way, affine, read, way};

#[test]
fn samples_are_the_function_at_their_place() {
    let field = |x: f64, y: f64, z: f64| (x - 3.0 * y + z * z) as f32;
    let dims = Dims::checked(5, 4, 3, 4).unwrap();
    let whole = formula(dims, affine(), field).unwrap();
    assert_eq!(way(&whole), Way::Positioned);
    let part = crop(whole, &[1..5, 0..4, 1..3]).unwrap();
    for ((k, j, i), &value) in read(part).indexed_iter() {
        let [x, y, z] = affine().apply([(i + 1) as f64, j as f64, (k + 1) as f64]);
        assert!((value - f64::from(field(x, y, z))).abs() < 1e-3);
    }
}

#[test]
fn an_affine_that_is_flat_is_refused() {
    let flat = Affine::from_columns([1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]);
    let dims = Dims::checked(5, 4, 3, 4).unwrap();
    assert_eq!(formula(dims, flat, |x, _, _| x as f32).err().unwrap().kind(), Kind::BadAffine);
}

/// One worker panics with a slab in hand, and the others would wait for that slab's turn for ever.
#[test]
fn a_formula_that_panics_ends_the_run() {
    let (told, ended) = channel();
    std::thread::spawn(move || {
        let folder = tempfile::tempdir().unwrap();
        let dims = Dims::checked(8, 8, 64, 4).unwrap();
        let field =
            |x: f64, _: f64, z: f64| if z == 20.0 { panic!("as it should") } else { x as f32 };
        let volume = formula(dims, Affine::IDENTITY, field).unwrap();
        let place = Place::new(&volume.meta.grid, Space::Ras).unwrap();
        let options = MeshOptions::new(MeshFormat::Stl);
        let mut file = MeshFile::create(&folder.path().join("x.stl"), &options).unwrap();
        let surfaces: Vec<(_, &mut dyn Sink)> = vec![(SurfaceOptions::at(3.5), &mut file)];
        let options = RunOptions { threads: 3, slab_planes: Some(2), ..RunOptions::default() };
        let run = || extract(volume, &place, surfaces, &options).map(|_| ());
        let _ = told.send(catch_unwind(AssertUnwindSafe(run)).is_err());
    });
    assert_eq!(ended.recv_timeout(Duration::from_mins(1)), Ok(true));
}
