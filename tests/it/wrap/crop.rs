//! `crop`: the samples of a box, read alone, in place.

use mcubes::cancel::Cancel;
use mcubes::error::{Failure, Kind};
use mcubes::geom::{Grid, Place, Space};
use mcubes::source::{AnyPlanes, Planes, RawInput, RawOptions, crop, open_raw};
use mcubes::volume::{Note, StoredType};
use ndarray::{Array3, s};

use super::sources::{Log, WAYS, Way, dims_of, planes, read, same, volume, way};

fn array() -> Array3<i16> {
    Array3::from_shape_fn((6, 5, 7), |(k, j, i)| (100 * k + 10 * j + i) as i16)
}

#[test]
fn a_box_holds_its_samples_and_can_be_had_as_before() {
    let array = array();
    let boxes = [[1..4, 2..5, 3..5], [0..7, 0..5, 5..6], [0..7, 1..2, 0..6], [6..7, 4..5, 0..1]];
    for which in WAYS {
        for [i, j, k] in boxes.clone() {
            let expected = array.slice(s![k.clone(), j.clone(), i.clone()]).mapv(f64::from);
            let log = Log::default();
            let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
            let part = crop(whole, &[i, j, k]).unwrap();
            assert_eq!(way(&part), which);
            assert!(same(&read(part), &expected), "{which:?}");
        }
    }
}

#[test]
fn only_the_planes_of_the_box_are_read_and_only_its_rows_where_they_can_be_had() {
    let array = array();
    let positioned = |log: &Log, i| {
        let whole = AnyPlanes::I16(planes(&array, Way::Positioned, log));
        read(crop(volume::<i16>(dims_of(&array), whole), &[i, 1..3, 4..6]).unwrap())
    };
    let log = Log::default();
    positioned(&log, 2..3);
    assert_eq!(*log.planes.lock().unwrap(), [5, 4]);
    for i in [2..3, 0..7] {
        let log = Log { has_rows: true, ..Log::default() };
        let part = positioned(&log, i.clone());
        assert_eq!(*log.rows.lock().unwrap(), [(5, 1, 2), (4, 1, 2)]);
        assert!(log.planes.lock().unwrap().is_empty());
        assert!(same(&part, &array.slice(s![4..6, 1..3, i]).mapv(f64::from)));
    }
}

#[test]
fn planes_in_order_are_read_to_the_end_of_the_stream_and_checked() {
    let array = array();
    let log = Log::default();
    let whole = AnyPlanes::I16(planes(&array, Way::Ordered, &log));
    let part = crop(volume::<i16>(dims_of(&array), whole), &[0..1, 0..1, 2..3]).unwrap();
    let AnyPlanes::I16(Planes::Ordered(mut part)) = part.planes else { panic!("not in order") };
    part.next_plane(ndarray::Array2::zeros((1, 1)).view_mut()).unwrap();
    assert_eq!(part.finish().unwrap(), [Note::AffineFromPixdim]);
    assert_eq!(*log.planes.lock().unwrap(), [0, 1, 2, 3, 4, 5]);
    assert!(*log.finished.lock().unwrap());
}

#[test]
fn a_box_of_a_box_is_the_box_of_both_and_stays_in_place_in_every_space() {
    let array = array();
    for which in WAYS {
        let log = Log::default();
        let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
        let before = whole.meta.grid.clone();
        let part = crop(crop(whole, &[1..6, 0..4, 2..6]).unwrap(), &[2..4, 1..3, 1..2]).unwrap();
        for space in [Space::Ras, Space::Lps, Space::Voxel] {
            let whole = Place::new(&before, space).unwrap();
            let here = Place::new(&part.meta.grid, space).unwrap();
            let (i, j) = (whole.step_i(), whole.step_j());
            let expected = [0, 1, 2].map(|a| whole.plane_origin(3)[a] + 3.0 * i[a] + j[a]);
            let found = here.plane_origin(0);
            assert!((0..3).all(|a| (expected[a] - found[a]).abs() < 1e-12), "{space:?}");
            assert_eq!((here.step_i(), here.is_reversed()), (i, whole.is_reversed()));
        }
        assert!(same(&read(part), &array.slice(s![3..4, 1..3, 3..5]).mapv(f64::from)));
    }
}

#[test]
fn uneven_planes_keep_their_gaps_in_the_facts() {
    let array = array();
    let log = Log::default();
    let mut whole =
        volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, Way::Resident, &log)));
    let origins = [0.0, 1.0, 3.0, 4.0, 8.0, 9.0].map(|z| [0.0, 0.0, z]).to_vec();
    let affine = mcubes::geom::Affine::IDENTITY;
    whole.meta.grid = Grid::uneven(dims_of(&array), affine, origins);
    whole.meta.gaps_mm = Some(vec![1.0, 2.0, 1.0, 4.0, 1.0]);
    let part = crop(whole, &[0..7, 0..5, 1..5]).unwrap();
    assert_eq!(part.meta.gaps_mm, Some(vec![2.0, 1.0, 4.0]));
}

#[test]
fn a_box_outside_the_volume_is_refused_with_the_range_and_the_size() {
    let array = array();
    let log = Log::default();
    let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, Way::Ordered, &log)));
    let refused = crop(whole, &[0..7, 2..6, 0..1]).err().unwrap();
    assert_eq!(refused.kind(), Kind::BadDims);
    assert_eq!(refused.to_string(), "crop j 2:6: the volume has j 0:5");
}

#[test]
fn a_box_of_a_file_is_the_box_of_its_samples() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let array = array();
    let bytes: Vec<u8> = array.iter().flat_map(|x| x.to_be_bytes()).collect();
    std::fs::write(file.path(), bytes).unwrap();
    let options = RawOptions { big_endian: true, ..RawOptions::new([7, 5, 6], StoredType::I16) };
    for [i, j, k] in [[0..7, 1..4, 2..5], [3..5, 4..5, 5..6], [0..7, 0..5, 0..6]] {
        let whole =
            open_raw(RawInput::Path(file.path().to_owned()), &options, &Cancel::new()).unwrap();
        let part = crop(whole, &[i.clone(), j.clone(), k.clone()]).unwrap();
        assert!(same(&read(part), &array.slice(s![k, j, i]).mapv(f64::from)));
    }
}
