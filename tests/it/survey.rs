//! What values a volume holds, against numpy's view and the formulas.

use mcubes::cancel::Cancel;
use mcubes::geom::{Affine, Dims, Grid};
use mcubes::source::{self, AnyPlanes, OpenOptions, Planes, RawInput, Volume, open_raw, survey};
use mcubes::volume::{Meta, Padding, Rescale, SourceFormat, StoredType, Survey};
use ndarray::{Array3, ArrayView3};

use crate::support::expected::{Entry, entries};
use crate::support::planes::samples;
use crate::support::repository;

fn of_array<'a, T: mcubes::volume::Sample>(
    array: &ArrayView3<'a, T>,
    planes: fn(Planes<'a, T>) -> AnyPlanes<'a>,
    change: impl Fn(&mut Meta),
) -> Survey {
    let (nz, ny, nx) = array.dim();
    let dims = Dims::checked(nx as i64, ny as i64, nz as i64, 8).unwrap();
    let mut meta = Meta::plain(SourceFormat::Memory, Grid::new(dims, Affine::IDENTITY), T::TYPE);
    change(&mut meta);
    survey(Volume { meta, planes: planes(Planes::Resident(*array)) }, &Cancel::new()).unwrap()
}

/// The greatest variance between two groups parted at any value, and that of parting at `iso`.
fn variances(values: &[f64], iso: f64) -> (f64, f64) {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let total: f64 = sorted.iter().sum();
    let (mut best, mut at_iso, mut sum) = (0.0, 0.0, 0.0);
    for (at, v) in sorted.iter().enumerate() {
        if at > 0 && sorted[at - 1] < *v {
            let (below, above) = (at as f64, n - at as f64);
            let apart = sum / below - (total - sum) / above;
            let between = below * above * apart * apart / (n * n);
            best = f64::max(best, between);
            if sorted[at - 1] < iso && iso <= *v {
                at_iso = between;
            }
        }
        sum += v;
    }
    (best, at_iso)
}

#[test]
fn ranges_and_counts_of_all_good_files_are_numpys() {
    for Entry { root, name: path, facts: entry } in entries("nifti").iter().filter(|e| e.is("good"))
    {
        let open =
            || source::open(&root.join(path), &OpenOptions::default(), &Cancel::new()).unwrap();
        let found = survey(open(), &Cancel::new()).unwrap();
        let close = |got: f64, want: f64| (got - want).abs() <= 1e-9 * want.abs();
        match (entry["min"].as_f64(), entry["max"].as_f64(), found.range) {
            (Some(min), Some(max), Some((low, high))) => {
                assert!(close(low, min) && close(high, max), "{path}: {low} to {high}");
            }
            (None, None, None) => {}
            other => panic!("{path}: {other:?}"),
        }
        assert_eq!(Some(found.n_nan + found.n_infinite), entry["nonfinite"].as_u64(), "{path}");
        let counted: u64 = found.histogram.counts.iter().sum();
        assert_eq!(counted + found.n_nan + found.n_infinite, found.n_samples, "{path}");
        assert!(found.histogram.counts.len() <= 256, "{path}");
        for s in found.suggested() {
            let (low, high) = found.range.unwrap();
            assert!(low < s.iso && s.iso <= high, "{path}: {s:?}");
        }
    }
}

#[test]
fn otsu_parts_real_scans_as_well_as_any_value_can() {
    let is_scan = |path: &str| ["ct_", "scale_", "f32"].iter().any(|part| path.contains(part));
    for entry in entries("nifti").iter().filter(|e| e.is("good") && is_scan(&e.name)) {
        let path = &entry.name;
        let open = || source::open(&entry.path(), &OpenOptions::default(), &Cancel::new()).unwrap();
        let found = survey(open(), &Cancel::new()).unwrap();
        let Some(otsu) = found.otsu else { continue };
        let volume = open();
        let rescale = volume.meta.rescale;
        let values: Vec<f64> =
            samples(volume).unwrap().0.into_iter().map(|v| rescale.real(v)).collect();
        let (best, at_otsu) = variances(&values, otsu);
        assert!(at_otsu >= best * (1.0 - 1e-4), "{path}: {at_otsu} at {otsu}, {best} elsewhere");
    }
}

#[test]
fn padding_is_no_part_of_the_range() {
    let mut array = Array3::<i16>::from_elem((3, 4, 5), 40);
    array[[0, 0, 0]] = -2000;
    array[[1, 1, 1]] = -1000;
    let pad = |meta: &mut Meta| meta.padding = Some(Padding { low: -2000.0, high: -2000.0 });
    let found = of_array(&array.view(), AnyPlanes::I16, pad);
    assert_eq!((found.range, found.n_padding), (Some((-1000.0, 40.0)), 1));
    let floats = array.mapv(f64::from);
    let found = of_array(&floats.view(), AnyPlanes::F64, pad);
    assert_eq!((found.range, found.n_padding), (Some((-1000.0, 40.0)), 1));
}

#[test]
fn bars_hold_what_lies_between_their_ends() {
    let array = Array3::from_shape_fn((10, 20, 30), |(k, j, i)| (k * j * i % 301) as u16);
    let found = of_array(&array.view(), AnyPlanes::U16, |_| {});
    let bars = found.histogram;
    let width = (bars.high - bars.low) / bars.counts.len() as f64;
    for (at, n) in bars.counts.iter().enumerate() {
        let (low, high) = (bars.low + width * at as f64, bars.low + width * (at + 1) as f64);
        let inside =
            array.iter().filter(|v| low <= f64::from(**v) && f64::from(**v) < high).count();
        assert_eq!(*n, inside as u64, "{low} to {high}");
    }
}

#[test]
fn a_strided_array_counts_like_a_contiguous_one() {
    let array = Array3::from_shape_fn((6, 7, 8), |(k, j, i)| (k * 56 + j * 8 + i) as f32);
    let whole = of_array(&array.view(), AnyPlanes::F32, |_| {});
    let turned = of_array(&array.view().permuted_axes([2, 0, 1]), AnyPlanes::F32, |_| {});
    assert_eq!(whole, turned);
    assert_eq!(whole.range, Some((0.0, 335.0)));
}

#[test]
fn a_head_in_hounsfield_units_suggests_bone_and_skin() {
    let head = repository("testdata/ct_head.nii.gz");
    let volume = source::open(&head, &OpenOptions::default(), &Cancel::new()).unwrap();
    let all = survey(volume, &Cancel::new()).unwrap().suggested();
    assert!(all.iter().any(|s| s.iso == 300.0 && s.meaning.starts_with("bone")));
    assert!(all.iter().any(|s| s.iso == -300.0 && s.meaning.starts_with("skin")));
}

#[test]
fn constant_and_empty_ranges_suggest_nothing() {
    let found = of_array(&Array3::<u8>::zeros((2, 2, 2)).view(), AnyPlanes::U8, |_| {});
    assert_eq!((found.range, found.otsu), (Some((0.0, 0.0)), None));
    assert!(found.suggested().is_empty());
    let nan = Array3::from_elem((2, 2, 2), f32::NAN);
    let found = of_array(&nan.view(), AnyPlanes::F32, |_| {});
    assert_eq!((found.range, found.n_nan), (None, 8));
    assert!(found.suggested().is_empty() && found.histogram.counts.is_empty());
}

#[test]
fn a_mask_suggests_half_of_its_least_label() {
    let mut mask = Array3::<u8>::zeros((4, 4, 4));
    mask[[1, 1, 1]] = 2;
    mask[[2, 1, 1]] = 7;
    let found = of_array(&mask.view(), AnyPlanes::U8, |_| {});
    assert!(found.suggested().iter().any(|s| s.iso == 1.0), "{:?}", found.suggested());
}

#[test]
fn a_raw_volume_is_surveyed_too() {
    let path = repository("testdata/raw/phantom_u8_le.raw");
    let options = source::RawOptions::new([20, 24, 28], StoredType::U8);
    let found =
        survey(open_raw(RawInput::Path(path), &options, &Cancel::new()).unwrap(), &Cancel::new())
            .unwrap();
    assert_eq!(found.range, Some((0.0, 240.0)));
}

#[test]
fn values_beyond_all_numbers_are_infinite_and_suggest_nothing() {
    let mut array = Array3::<i16>::zeros((3, 4, 5));
    array[[0, 0, 0]] = 30_000;
    array[[1, 1, 1]] = 2;
    let far = |meta: &mut Meta| meta.rescale = Rescale::new(1e304, 0.0).unwrap();
    let found = of_array(&array.view(), AnyPlanes::I16, far);
    assert_eq!((found.range, found.n_infinite), (Some((0.0, 2e304)), 1));
    assert_eq!(found.otsu, Some(1e304));
    assert!(found.suggested().iter().all(|s| s.iso.is_finite()), "{:?}", found.suggested());
    assert!(found.histogram.low.is_finite() && found.histogram.high.is_finite());
    assert_eq!(found.histogram.counts.iter().sum::<u64>() + found.n_infinite, found.n_samples);
    let all = array.mapv(|v| if v > 0 { 1e308 } else { -1e308 });
    let far = |meta: &mut Meta| meta.rescale = Rescale::new(1e3, 0.0).unwrap();
    let found = of_array(&all.view(), AnyPlanes::F64, far);
    assert_eq!((found.range, found.otsu, found.n_infinite), (None, None, 60));
    assert!(found.suggested().is_empty() && found.histogram.counts.is_empty());
}
