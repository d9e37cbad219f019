//! Series that hold several images at each position: whole volumes come out, each of one kind, or
//! an error; never a fragment, never a mixture.

use mcubes::error::Kind;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use tempfile::TempDir;

use crate::support::dicom::{EXPLICIT, Elements, Series};

const N_SLICES: usize = 30;

type Tag = (u16, u16);

const ACQUISITION_NUMBER: Tag = (0x0020, 0x0012);
const INSTANCE_NUMBER: Tag = (0x0020, 0x0013);
const POSITION: Tag = (0x0020, 0x0032);
const STUDY: Tag = (0x0020, 0x000D);
const SERIES: Tag = (0x0020, 0x000E);
const SERIES_NUMBER: Tag = (0x0020, 0x0011);
const PIXEL_SPACING: Tag = (0x0028, 0x0030);

/// `n_parts` images at each of so many positions; the folder of a file tells its part. The parts
/// differ in their samples.
fn mixed(n_parts: usize, edit: impl Fn(usize, usize, &mut Elements)) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    for part in 0..n_parts {
        let mut series = Series::axial(N_SLICES);
        series.body.semi[0] -= part as f64;
        let name = folder.path().join(part.to_string());
        series.write_as(&name, EXPLICIT, |k, data| edit(part, k, data));
    }
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    (folder, study)
}

/// Images counted position by position, at every second one backwards: A B, B A, A B, ...
fn snake(n_parts: usize, part: usize, k: usize) -> usize {
    k * n_parts + if k.is_multiple_of(2) { part } else { n_parts - 1 - part } + 1
}

/// All volumes are whole, of one part each, and can be meshed.
fn assert_whole(study: &Study, n_parts: usize, what: &str) {
    assert_eq!(study.volumes.len(), n_parts, "{what}");
    for index in 0..n_parts {
        assert!(study.open(index, &OpenOptions::default()).is_ok(), "{what}");
        let slices = study.slices(index);
        assert_eq!(slices.len(), N_SLICES, "{what}");
        let parts: Vec<_> = slices.iter().map(|(name, _)| name.split('/').next()).collect();
        assert!(parts.iter().all(|p| p == &parts[0]), "{what}: {parts:?}");
    }
}

#[test]
fn numbers_that_count_slices_or_blocks_of_them_break_no_repeat_up() {
    type Number = fn(usize, usize) -> f64;
    let cases: [(&str, Tag, [u8; 2], usize, Number); 7] = [
        ("blocks", ACQUISITION_NUMBER, *b"IS", 2, |p, k| (p * 3 + k / 10 + 1) as f64),
        ("two blocks", ACQUISITION_NUMBER, *b"IS", 2, |p, k| (p * 2 + k / 15 + 1) as f64),
        ("blocks in turn", ACQUISITION_NUMBER, *b"IS", 2, |p, k| (k / 10 * 2 + p + 1) as f64),
        ("each", ACQUISITION_NUMBER, *b"IS", 3, |p, k| (p * 30 + k + 1) as f64),
        ("each in turn", ACQUISITION_NUMBER, *b"IS", 3, |p, k| (k * 3 + p + 1) as f64),
        ("times", (0x0018, 0x1060), *b"DS", 3, |p, k| p as f64 * 33.0 + k as f64 * 0.7),
        ("temporal position", (0x0020, 0x0100), *b"IS", 3, |p, k| (k * 3 + p + 1) as f64),
    ];
    for (what, tag, vr, n_parts, number) in cases {
        let (_folder, study) = mixed(n_parts, |part, k, data| {
            data.set_text(tag, vr, number(part, k));
            data.set_text(INSTANCE_NUMBER, *b"IS", k * n_parts + part + 1);
        });
        assert_whole(&study, n_parts, what);
    }
}

#[test]
fn blocks_of_slices_stay_together_where_a_slice_is_missing() {
    let (folder, _) = mixed(2, |part, k, data| {
        data.set_text(ACQUISITION_NUMBER, *b"IS", part * 3 + k / 10 + 1);
    });
    let lost = std::fs::read_dir(folder.path().join("1")).unwrap().next().unwrap().unwrap();
    std::fs::remove_file(lost.path()).unwrap();
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let error = study.open(study.default().unwrap(), &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::ConflictingSlices, "{error}");
}

#[test]
fn what_the_scanner_was_set_to_separates_images_whose_order_does_not() {
    let cases: [(Tag, [u8; 2], [&str; 2]); 5] = [
        ((0x0018, 0x0060), *b"DS", ["80", "140"]),
        ((0x0018, 0x1210), *b"SH", ["B30f", "B70f"]),
        ((0x0018, 0x0082), *b"DS", ["100", "900"]),
        ((0x0018, 0x1314), *b"DS", ["5", "20"]),
        ((0x0018, 0x9089), *b"FD", ["aaaaaaaa", "bbbbbbbb"]),
    ];
    for (tag, vr, values) in cases {
        let (_folder, study) = mixed(2, |part, k, data| {
            data.set_text(tag, vr, values[part]);
            data.set_text(INSTANCE_NUMBER, *b"IS", snake(2, part, k));
            // An order by time is believed only where nothing else tells the images apart.
            data.set_text((0x0008, 0x0032), *b"TM", 120_000 + snake(2, part, k));
        });
        assert_whole(&study, 2, &format!("{tag:?}"));
    }
}

#[test]
fn a_time_of_day_separates_repeats_and_is_not_told() {
    let (_folder, study) = mixed(2, |part, k, data| {
        data.set_text((0x0008, 0x0032), *b"TM", format!("12{part:02}{k:02}.5"));
        data.set_text(INSTANCE_NUMBER, *b"IS", snake(2, part, k));
    });
    assert_whole(&study, 2, "time");
    let apart: Vec<_> = study.volumes.iter().filter_map(|v| v.apart.as_deref()).collect();
    assert_eq!(apart, ["time 1 of 2", "time 2 of 2"]);
}

#[test]
fn without_a_series_uid_the_study_the_number_and_the_description_name_the_series() {
    for value in [None, Some("")] {
        let differ: [(Tag, [u8; 2], [&str; 2]); 3] = [
            (SERIES_NUMBER, *b"IS", ["1", "2"]),
            ((0x0008, 0x103E), *b"LO", ["thin", "thick"]),
            (STUDY, *b"UI", ["1.2.3", "1.2.4"]),
        ];
        for (tag, vr, values) in differ {
            let (_folder, study) = mixed(2, |part, _, data| {
                data.remove(SERIES);
                if let Some(value) = value {
                    data.set_text(SERIES, *b"UI", value);
                }
                data.set_text(tag, vr, values[part]);
            });
            assert_whole(&study, 2, &format!("{tag:?} {value:?}"));
        }
    }
}

#[test]
fn one_series_uid_in_two_studies_is_two_series() {
    // Beside each other, so that no position tells them apart.
    let (_folder, study) = mixed(2, |part, k, data| {
        data.set_text(STUDY, *b"UI", ["1.2.3", "1.2.4"][part]);
        data.set_text(POSITION, *b"DS", format!("0\\0\\{}", k as f64 + part as f64 * 50.0));
    });
    assert_whole(&study, 2, "studies");
    // A study that some files have lost is no other one.
    let (_folder, study) = mixed(1, |_, k, data| {
        if k % 3 > 0 {
            data.set_text(STUDY, *b"UI", "1.2.3");
        }
    });
    assert_whole(&study, 1, "lost");
}

#[test]
fn images_that_nearly_lie_at_one_position_are_at_one_position() {
    let (_folder, study) = mixed(2, |part, k, data| {
        let z = k as f64 * 1.8 + part as f64 * 0.002;
        data.set_text(POSITION, *b"DS", format!("0\\0\\{z:.4}"));
        data.set_text(INSTANCE_NUMBER, *b"IS", 7);
    });
    let error = study.open(0, &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::ConflictingSlices, "{error}");
    assert!(error.to_string().contains("positions hold"), "{error}");
}

#[test]
fn one_position_with_many_images_is_one_position() {
    let (_folder, study) = mixed(1, |_, k, data| {
        let z = if k < 12 { k } else { k.max(15) - 3 };
        data.set_text(POSITION, *b"DS", format!("0\\0\\{z}"));
    });
    let error = study.open(0, &OpenOptions::default()).err().unwrap().to_string();
    assert!(error.contains("1 position holds more than one image"), "{error}");
}

#[test]
fn one_image_is_no_volume_unless_it_gives_a_spacing_between_slices() {
    for spacing in [None, Some("1.5")] {
        let mut series = Series::axial(1);
        if let Some(spacing) = spacing {
            series.extra.text((0x0018, 0x0088), *b"DS", spacing);
        }
        let folder = TempDir::new().unwrap();
        series.write(folder.path());
        let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
        match study.open(0, &OpenOptions::default()) {
            Ok(volume) => {
                assert_eq!((spacing, volume.meta.grid.dims.nz()), (Some("1.5"), 1));
                assert!(volume.meta.notes.iter().any(|note| note.to_string().contains("flat")));
            }
            Err(error) => assert_eq!((spacing, error.kind()), (None, Kind::UnfitSeries)),
        }
    }
}

#[test]
fn images_that_each_stand_alone_say_what_keeps_them_from_each_other() {
    let (_folder, study) = mixed(1, |_, k, data| {
        data.set_text(PIXEL_SPACING, *b"DS", format!("1\\{}", 1.0 + k as f64 / 10.0));
    });
    let error = study.open(0, &OpenOptions::default()).err().unwrap();
    let line = error.to_string();
    assert!(line.contains("29 images of the same series"), "{line}");
    assert!(line.contains("another PixelSpacing"), "{line}");
    assert!(!error.hint().unwrap().contains("give the folder"), "{:?}", error.hint());
}

#[test]
fn slices_beside_their_line_are_not_called_unevenly_spaced() {
    let (_folder, study) = mixed(1, |_, k, data| {
        let x = if k == 12 { 5.0 } else { 0.0 };
        data.set_text(POSITION, *b"DS", format!("{x}\\0\\{}", k as f64 * 1.8));
    });
    let notes = study.volumes[0].meta.as_ref().unwrap().notes.iter().map(ToString::to_string);
    let said: Vec<String> = notes.collect();
    assert!(said.iter().any(|n| n.contains("up to 5.00 mm beside it")), "{said:?}");
    assert!(!said.iter().any(|n| n.contains("uneven")), "{said:?}");
}
