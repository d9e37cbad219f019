//! `formula`: the values of a function of millimetres.

use mcubes::error::{Failure, Kind};
use mcubes::geom::{Affine, Dims};
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
