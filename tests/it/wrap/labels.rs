//! `mask`, `two_values`, and padding.

use mcubes::cancel::Cancel;
use mcubes::error::{Failure, Kind};
use mcubes::source::{AnyPlanes, crop, is_active, mask, pad_out, two_values};
use mcubes::volume::{Inside, Padding, Rescale, Side, StoredType};
use ndarray::{Array3, s};

use super::sources::{Log, WAYS, Way, dims_of, planes, read, same, volume, way};

fn labels() -> Array3<i16> {
    Array3::from_shape_fn((3, 4, 5), |(k, j, i)| ((7 * k + 3 * j + i) % 9) as i16 - 2)
}

#[test]
fn a_mask_is_1_where_the_stored_value_is_one_of_the_list() {
    let array = labels();
    for which in WAYS {
        // Short lists are compared, long ones looked up; values that an i16 cannot have, doubles
        // and NaN change nothing.
        for list in [vec![-2.0, 5.0, 0.5, 1e9, f64::NAN], vec![-2.0, -1.0, 0.0, 4.0, 5.0, 5.0]] {
            let log = Log::default();
            let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
            let marked = mask(whole, &list).unwrap();
            assert!(matches!(marked.planes, AnyPlanes::U8(_)));
            let expected = array.mapv(|x| f64::from(u8::from(list.contains(&f64::from(x)))));
            assert!(same(&read(marked), &expected), "{which:?} {list:?}");
        }
    }
}

#[test]
fn a_mask_goes_by_stored_values_and_leaves_padding_out() {
    let array = Array3::from_shape_vec((1, 1, 4), vec![0.0_f32, f32::NAN, 1.5, -9.0]).unwrap();
    let log = Log::default();
    let whole = AnyPlanes::F32(planes(&array, Way::Positioned, &log));
    let mut whole = volume::<f32>(dims_of(&array), whole);
    whole.meta.rescale = Rescale::new(10.0, 3.0).unwrap();
    whole.meta.padding = Some(Padding { low: -10.0, high: -8.5 });
    let marked = mask(whole, &[-0.0, 1.5, -9.0, f64::NAN]).unwrap();
    assert_eq!((marked.meta.rescale, marked.meta.padding), (Rescale::IDENTITY, None));
    assert_eq!(read(marked).into_raw_vec_and_offset().0, [1.0, 0.0, 1.0, 0.0]);
}

#[test]
fn labels_that_f64_does_not_tell_apart_are_refused() {
    // IEEE 754: 2⁵³ and 2⁵³ + 1 are one f64, 2⁵³ - 1 and 2⁵³ are two.
    let exact = (1_i64 << 53) - 1;
    let array = Array3::from_elem((2, 2, 2), exact as f64);
    for stored in [StoredType::I64, StoredType::U64, StoredType::F64] {
        let marked = |label: i64| {
            let log = Log::default();
            let planes = AnyPlanes::F64(planes(&array, Way::Positioned, &log));
            let mut whole = volume::<f64>(dims_of(&array), planes);
            whole.meta.stored = stored;
            mask(whole, &[0.0, label as f64]).map(read)
        };
        assert!(marked(exact).unwrap().iter().all(|&x| x == 1.0), "{stored}");
        for label in [exact + 1, exact + 2, i64::MIN] {
            let error = marked(label).err().map(|e| e.kind());
            let refused = (stored != StoredType::F64).then_some(Kind::BadConfig);
            assert_eq!(error, refused, "{stored} {label}");
        }
    }
}

#[test]
fn a_volume_of_two_values_has_its_level_halfway() {
    let half = |values: Vec<f32>, slope: f64, inter: f64, padding: Option<Padding>| {
        let array = Array3::from_shape_vec((1, 1, values.len()), values).unwrap();
        WAYS.map(|which| {
            let log = Log::default();
            let planes = AnyPlanes::F32(planes(&array, which, &log));
            let mut volume = volume::<f32>(dims_of(&array), planes);
            volume.meta.rescale = Rescale::new(slope, inter).unwrap();
            volume.meta.padding = padding;
            two_values(volume, &Cancel::new()).unwrap()
        })
    };
    assert_eq!(half(vec![0.0, 1.0, 1.0, 0.0], 1.0, 0.0, None), [Some(0.5); 3]);
    assert_eq!(half(vec![255.0, 0.0], 0.5, 0.0, None), [Some(63.75); 3]);
    assert_eq!(half(vec![-1.0, 0.0], 1.0, 0.0, None), [None; 3]);
    assert_eq!(half(vec![1.0, 2.0], 1.0, 0.0, None), [None; 3]);
    assert_eq!(half(vec![1.0, 2.0], 1.0, -1.0, None), [Some(0.5); 3]);
    assert_eq!(half(vec![0.0, 0.0], 1.0, 0.0, None), [None; 3]);
    assert_eq!(half(vec![0.0, 1.0, 2.0], 1.0, 0.0, None), [None; 3]);
    assert_eq!(half(vec![0.0, f32::NAN, 1.0], 1.0, 0.0, None), [Some(0.5); 3]);
    assert_eq!(half(vec![0.0, f32::INFINITY], 1.0, 0.0, None), [None; 3]);
    let padding = Some(Padding { low: 2.0, high: 2.0 });
    assert_eq!(half(vec![0.0, 1.0, 2.0], 1.0, 0.0, padding), [Some(0.5); 3]);
}

#[test]
fn padding_is_taken_out_only_where_its_own_value_would_be_inside() {
    let array = Array3::from_shape_fn((2, 3, 4), |(k, j, i)| (12 * k + 4 * j + i) as u8);
    let out = |iso: f64, below: bool, slope: f64| {
        let side = if below { Side::Below } else { Side::AtLeast };
        WAYS.map(|which| {
            let log = Log::default();
            let whole = AnyPlanes::U8(planes(&array, which, &log));
            let mut whole = volume::<u8>(dims_of(&array), whole);
            whole.meta.rescale = Rescale::new(slope, 0.0).unwrap();
            whole.meta.padding = Some(Padding { low: 4.5, high: 8.0 });
            let active = is_active(&whole.meta, Inside { iso, side });
            let done = pad_out(whole, Inside { iso, side });
            assert_eq!(done.meta.padding.is_none(), active);
            assert_eq!(matches!(done.planes, AnyPlanes::F64(_)), active);
            (active, way(&done) == Way::Ordered, read(done))
        })
    };
    let without = |gone: std::ops::RangeInclusive<u8>| {
        array.mapv(|x| if gone.contains(&x) { f64::NAN } else { f64::from(x) })
    };
    let nothing: std::ops::RangeInclusive<u8> = std::ops::RangeInclusive::new(1, 0);
    for (iso, below, slope, active, gone) in [
        (2.0, false, 1.0, true, 5..=8),
        (7.0, false, 1.0, true, 7..=8),
        (9.0, false, 1.0, false, nothing.clone()),
        (7.0, true, 1.0, true, 5..=6),
        (4.5, true, 1.0, false, nothing.clone()),
        (-6.0, false, -1.0, true, 5..=6),
        (-9.0, true, -1.0, false, nothing),
    ] {
        for (found, ordered, samples) in out(iso, below, slope) {
            assert_eq!(found, active, "{iso} {below} {slope} {ordered}");
            assert!(same(&samples, &without(gone.clone())), "{iso} {below} {slope} {ordered}");
        }
    }
}

#[test]
fn steps_compose() {
    let array = labels();
    for which in WAYS {
        let log = Log::default();
        let mut whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
        whole.meta.padding = Some(Padding { low: 3.0, high: 3.0 });
        let marked = crop(mask(whole, &[3.0, 4.0]).unwrap(), &[1..5, 0..2, 1..3]).unwrap();
        let expected = array.mapv(|x| f64::from(u8::from(x == 4)));
        assert!(same(&read(marked), &expected.slice(s![1..3, 0..2, 1..5]).to_owned()));
    }
}

/// As a DICOM series is whose slope changes from slice to slice.
#[test]
fn labels_are_refused_where_only_real_values_are_to_be_had() {
    let array = Array3::<f64>::zeros((3, 2, 2));
    let log = Log::default();
    let whole = AnyPlanes::F64(planes(&array, Way::Resident, &log));
    let whole = volume::<i16>(dims_of(&array), whole);
    let refused = mask(whole, &[3.0]).err().unwrap();
    assert_eq!(refused.kind(), Kind::UnfitSeries);
    let whole = AnyPlanes::F64(planes(&array, Way::Resident, &log));
    assert!(mask(volume::<f64>(dims_of(&array), whole), &[3.0]).is_ok());
}
