//! DICOM that holds no volume, or several in one: told apart, or refused by name with what to do.

use std::path::Path;

use mcubes::Error;
use mcubes::error::Kind;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{Ellipsoid, Series};
use crate::support::repository;

fn scan(folder: &Path) -> Study {
    dicom::scan(folder, &ScanOptions::default()).unwrap()
}

/// Why the volume that is taken unasked does not open.
fn refusal(path: &Path) -> Error {
    let study = dicom::scan(path, &ScanOptions::default()).unwrap();
    match study.default() {
        Ok(index) => study.open(index, &OpenOptions::default()).err().unwrap(),
        Err(error) => error,
    }
}

const N_SLICES: usize = 9;

/// Three repeats of a series in one folder, each with an ellipsoid of its own height; `number` gives
/// the InstanceNumber of a slice of a repeat.
fn repeats(number: impl Fn(usize, usize) -> usize) -> TempDir {
    let folder = TempDir::new().unwrap();
    for repeat in 0..3 {
        let mut series = Series::axial(N_SLICES);
        series.body = Ellipsoid { semi: [17.0, 12.0, 4.0 + repeat as f64], ..series.body };
        for k in 0..N_SLICES {
            // Names say nothing of the order.
            let name = format!("{:03}", (repeat * N_SLICES + k) * 17 % 101);
            std::fs::write(folder.path().join(name), series.image(k, number(repeat, k))).unwrap();
        }
    }
    folder
}

fn alone(repeat: usize) -> Vec<f64> {
    let folder = TempDir::new().unwrap();
    let mut series = Series::axial(N_SLICES);
    series.body = Ellipsoid { semi: [17.0, 12.0, 4.0 + repeat as f64], ..series.body };
    series.write(folder.path());
    values(scan(folder.path()).open(0, &OpenOptions::default()).unwrap()).unwrap()
}

#[test]
fn repeats_that_only_instance_numbers_tell_apart_are_volumes_of_their_own() {
    let by_volume = repeats(|repeat, k| 5 + repeat * N_SLICES + k);
    let by_slice = repeats(|repeat, k| 100 * (N_SLICES - k) + repeat);
    for folder in [by_volume, by_slice] {
        let study = scan(folder.path());
        assert_eq!(study.volumes.len(), 3);
        assert_eq!(study.default().unwrap(), 0);
        for repeat in 0..3 {
            let title = study.volumes[repeat].title();
            assert!(title.contains(&format!("repeat {} of 3", repeat + 1)), "{title}");
            let found = study.open(repeat, &OpenOptions::default()).unwrap();
            assert_eq!(values(found).unwrap(), alone(repeat));
        }
    }
}

#[test]
fn repeats_whose_instance_numbers_are_in_no_order_are_refused_with_file_names() {
    // All numbers differ, but they run neither repeat after repeat nor slice after slice.
    let mixed = repeats(|repeat, k| 1 + (repeat * N_SLICES + k) * 11 % 101);
    let same = repeats(|_, k| 1 + k);
    for folder in [mixed, same] {
        let error = refusal(folder.path());
        assert_eq!(error.kind(), Kind::ConflictingSlices, "{error}");
        assert!(error.to_string().contains(" and "), "{error}");
    }
}

#[test]
fn a_modality_lut_is_refused_by_name() {
    let mut series = Series::axial(3);
    // One empty item of undefined length, and the sequence's end.
    let item = [[0xFE, 0xFF, 0x00, 0xE0], [0; 4]].concat();
    series.extra.element((0x0028, 0x3000), *b"SQ", &item);
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let error = refusal(folder.path());
    assert_eq!(error.kind(), Kind::UnsupportedType);
    assert!(error.to_string().contains("a Modality LUT Sequence is not read"), "{error}");
}

#[test]
fn a_mosaic_is_refused_by_name_with_what_to_do() {
    let folder = TempDir::new().unwrap();
    Series { image_type: "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC", ..Series::axial(3) }
        .write(folder.path());
    let error = refusal(folder.path());
    assert_eq!(error.kind(), Kind::UnfitSeries);
    assert!(error.to_string().contains("a Siemens mosaic"), "{error}");
    assert!(error.hint().unwrap().contains("dcm2niix"));
}

#[test]
fn a_syntax_that_is_not_decoded_is_named_even_where_the_file_stands_alone() {
    let folder = repository("testdata/dicom-bad");
    for (name, said) in [
        ("unknown-transfer-syntax.dcm", "(unknown) is not decoded"),
        ("ts-jpeg-extended", "1.2.840.10008.1.2.4.51 (JPEG extended, 12 bits)"),
    ] {
        let error = refusal(&folder.join(name));
        assert_eq!(error.kind(), Kind::UnsupportedSyntax, "{error}");
        assert!(error.to_string().contains(said), "{error}");
        assert!(error.hint().unwrap().contains("dcmdjpeg"));
    }
}

#[test]
fn a_damaged_jpeg_ls_frame_says_what_is_wrong_with_it() {
    let folder = repository("testdata/dicom-bad");
    for (name, kind, said) in [
        ("jpegls-truncated.dcm", Kind::TruncatedData, "the data end in row"),
        (
            "jpegls-wrong-size.dcm",
            Kind::CorruptPixels,
            "the frame is 3000 x 3000, expected 12 x 10",
        ),
    ] {
        let copy = TempDir::new().unwrap();
        for entry in std::fs::read_dir(folder.join("good-series")).unwrap() {
            let good = entry.unwrap().path();
            std::fs::copy(&good, copy.path().join(good.file_name().unwrap())).unwrap();
        }
        std::fs::copy(folder.join(name), copy.path().join("IM2.dcm")).unwrap();
        let study = scan(copy.path());
        let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
        let error = mcubes::source::survey(volume, &mcubes::cancel::Cancel::new()).unwrap_err();
        let error = Error::at(copy.path(), error);
        assert_eq!(error.kind(), kind, "{error}");
        assert!(
            error.to_string().contains("IM2.dcm: ") && error.to_string().contains(said),
            "{error}"
        );
    }
}

/// Nine slices of which the last is cut short within its samples; the folder, and its path.
fn cut_at_the_end() -> (TempDir, std::path::PathBuf, Vec<u8>) {
    let folder = TempDir::new().unwrap();
    let series = Series::axial(N_SLICES);
    for k in 0..N_SLICES {
        std::fs::write(folder.path().join(format!("S{k}")), series.image(k, k + 1)).unwrap();
    }
    let last = folder.path().join(format!("S{}", N_SLICES - 1));
    let whole = std::fs::read(&last).unwrap();
    std::fs::write(&last, &whole[..whole.len() - 999]).unwrap();
    (folder, last, whole)
}

#[test]
fn a_slice_cut_short_is_refused_wherever_it_lies_unless_a_whole_one_is_in_its_place() {
    let (folder, _, whole) = cut_at_the_end();
    let error = refusal(folder.path());
    assert_eq!(error.kind(), Kind::TruncatedData, "{error}");
    assert!(error.to_string().contains("S8: element (7FE0,0010) claims"), "{error}");
    // A copy that is whole completes the volume.
    std::fs::write(folder.path().join("again"), whole).unwrap();
    let study = scan(folder.path());
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    assert_eq!(volume.meta.grid.dims.nz(), N_SLICES);
    let notes: Vec<String> = volume.meta.notes.iter().map(ToString::to_string).collect();
    assert!(notes[0].contains("a whole image is in its place: S8: element"), "{notes:?}");
}

#[test]
fn an_image_that_ends_before_its_samples_is_named_and_no_object_without_pixels() {
    let (folder, last, whole) = cut_at_the_end();
    let at = whole.windows(4).position(|w| w == [0xE0, 0x7F, 0x10, 0x00]).unwrap();
    std::fs::write(last, &whole[..at]).unwrap();
    let study = scan(folder.path());
    assert_eq!(study.faults.len(), 1);
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    let notes: Vec<String> = volume.meta.notes.iter().map(ToString::to_string).collect();
    assert!(notes[0].contains("left out: S8: PixelData is absent"), "{notes:?}");
}
