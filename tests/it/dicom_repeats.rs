//! Repeats of a series that do not lie slice on slice, that are broken off, or that differ in
//! worth: each whole one is a volume, nothing is interleaved, and the best is the default.

use mcubes::error::Kind;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use tempfile::TempDir;

use crate::support::dicom::{EXPLICIT, Elements, Series};

type Tag = (u16, u16);

const IMAGE_TYPE: Tag = (0x0008, 0x0008);
const ECHO_TIME: Tag = (0x0018, 0x0081);
const ACQUISITION_NUMBER: Tag = (0x0020, 0x0012);
const POSITION: Tag = (0x0020, 0x0032);
const TEMPORAL_POSITION: Tag = (0x0020, 0x0100);

/// One part for each number of slices; the folder of a file tells its part, and the parts differ
/// in their samples.
fn parts(lengths: &[usize], edit: impl Fn(usize, usize, &mut Elements)) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    for (part, &n) in lengths.iter().enumerate() {
        let mut series = Series::axial(8);
        series.body.semi[0] -= part as f64;
        series.positions.truncate(n);
        let name = folder.path().join(part.to_string());
        series.write_as(&name, EXPLICIT, |k, data| edit(part, k, data));
    }
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    (folder, study)
}

fn place(data: &mut Elements, z: f64) {
    data.set_text(POSITION, *b"DS", format!("0\\0\\{z:.3}"));
}

/// The parts that a volume's slices are of, each once.
fn parts_of(study: &Study, index: usize) -> Vec<&str> {
    let mut parts: Vec<_> =
        study.slices(index).iter().filter_map(|(name, _)| name.split('/').next()).collect();
    parts.dedup();
    parts
}

fn notes(study: &Study, index: usize) -> String {
    let volume = study.open(index, &OpenOptions::default()).unwrap();
    let notes: Vec<String> = volume.meta.notes.iter().map(ToString::to_string).collect();
    notes.join("\n")
}

#[test]
fn time_points_and_echoes_at_shifted_positions_are_never_interleaved() {
    let tags = [(TEMPORAL_POSITION, *b"IS"), (ECHO_TIME, *b"DS"), ((0x0018, 0x0086), *b"IS")];
    for (tag, vr) in tags {
        // Half a step makes an even grid of thinner slices; 0.05 mm looks like missing slices.
        for shift in [1.0, 0.7, 0.05, 3.0] {
            let (_folder, study) = parts(&[8, 8], |part, k, data| {
                data.set_text(tag, vr, part + 1);
                place(data, 2.0 * k as f64 + shift * part as f64);
            });
            let what = format!("{tag:?} {shift}");
            assert_eq!(study.volumes.len(), 2, "{what}");
            for index in 0..2 {
                let volume = study.open(index, &OpenOptions::default()).unwrap();
                assert_eq!(volume.meta.grid.dims.nz(), 8, "{what}");
                assert_eq!(parts_of(&study, index), [index.to_string()], "{what}");
            }
        }
    }
}

#[test]
fn a_slice_missing_in_one_of_two_shifted_time_points_mixes_them_no_more() {
    let (_folder, study) = parts(&[8, 7], |part, k, data| {
        data.set_text(TEMPORAL_POSITION, *b"IS", part + 1);
        let k = if part == 1 && k > 3 { k + 1 } else { k };
        place(data, 2.0 * k as f64 + 0.7 * part as f64);
    });
    assert_eq!(study.volumes.len(), 2);
    assert_eq!(study.slices(0).len(), 8);
    let error = study.open(1, &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::MissingSlices, "{error}");
}

#[test]
fn a_shifted_repeat_that_was_broken_off_is_left_out_and_named() {
    for (whole, rest) in [(1, 1), (1, 2), (2, 1), (2, 2), (5, 3)] {
        let mut lengths = vec![8; whole];
        lengths.push(rest);
        let (_folder, study) = parts(&lengths, |part, k, data| {
            data.set_text(TEMPORAL_POSITION, *b"IS", part + 1);
            place(data, 2.0 * k as f64 + 0.3 * part as f64);
        });
        let what = format!("{whole} and {rest} slices");
        assert_eq!(study.all(), (0..whole).collect::<Vec<_>>(), "{what}");
        for index in 0..whole {
            assert_eq!(study.slices(index).len(), 8, "{what}");
            assert_eq!(parts_of(&study, index), [index.to_string()], "{what}");
            let wanted = format!("temporal position {} was broken off", whole + 1);
            assert!(notes(&study, index).contains(&wanted), "{what}");
        }
    }
}

#[test]
fn a_slice_whose_echo_time_is_written_otherwise_stays_in_its_volume() {
    for odd in [0, 3, 7] {
        let (_folder, study) = parts(&[8], |_, k, data| {
            data.set_text(ECHO_TIME, *b"DS", if k == odd { "10.01" } else { "10" });
        });
        assert_eq!(study.volumes.len(), 1);
        assert_eq!(study.open(0, &OpenOptions::default()).unwrap().meta.grid.dims.nz(), 8);
    }
}

#[test]
fn an_echo_time_is_the_same_however_it_is_written() {
    for shift in [0.0, 0.7] {
        let (_folder, study) = parts(&[8, 8], |part, k, data| {
            let time = if k % 2 == 0 { ["10", "20"] } else { ["10.0", "2.00e1"] };
            data.set_text(ECHO_TIME, *b"DS", time[part]);
            place(data, 2.0 * k as f64 + shift * part as f64);
        });
        let apart: Vec<_> = study.volumes.iter().filter_map(|v| v.apart.as_deref()).collect();
        assert_eq!(apart, ["echo time 10", "echo time 20"], "{shift}");
        assert_eq!(parts_of(&study, 1), ["1"], "{shift}");
    }
}

#[test]
fn interleaved_packages_and_blocks_of_slices_are_one_volume() {
    type Place = fn(usize, usize) -> f64;
    // Packages are told by their numbers; blocks follow each other, whatever numbers them.
    let in_turn = |part: usize, k: usize| 2.0 * k as f64 + part as f64;
    let in_blocks = |part: usize, k: usize| (8 * part + k) as f64;
    let cases: [(Tag, [u8; 2], Place); 4] = [
        (ACQUISITION_NUMBER, *b"IS", in_turn),
        ((0x0008, 0x0032), *b"TM", in_turn),
        (TEMPORAL_POSITION, *b"IS", in_blocks),
        (ECHO_TIME, *b"DS", in_blocks),
    ];
    for (tag, vr, z) in cases {
        let (_folder, study) = parts(&[8, 8], |part, k, data| {
            data.set_text(tag, vr, 100_000 + part);
            place(data, z(part, k));
        });
        assert_eq!(study.volumes.len(), 1, "{tag:?}");
        assert_eq!(study.open(0, &OpenOptions::default()).unwrap().meta.grid.dims.nz(), 16);
    }
}

#[test]
fn the_whole_repeats_of_a_series_broken_off_are_volumes_and_the_rest_is_named() {
    for (whole, rest) in [(1, 1), (1, 2), (2, 1), (2, 3), (5, 2), (10, 1)] {
        let mut lengths = vec![8; whole];
        lengths.push(rest);
        for (tag, vr, name) in [
            (TEMPORAL_POSITION, *b"IS", "temporal position"),
            (ECHO_TIME, *b"DS", "echo time"),
            (ACQUISITION_NUMBER, *b"IS", "acquisition number"),
        ] {
            let (_folder, study) =
                parts(&lengths, |part, _, data| data.set_text(tag, vr, part + 1));
            let what = format!("{name}, {whole} and {rest} slices");
            assert_eq!(study.default().unwrap(), 0, "{what}");
            assert_eq!(study.all(), (0..whole).collect::<Vec<_>>(), "{what}");
            for index in 0..whole {
                assert_eq!(study.slices(index).len(), 8, "{what}");
                assert_eq!(parts_of(&study, index), [index.to_string()], "{what}");
                let said = notes(&study, index);
                let s = if rest == 1 { "" } else { "s" };
                let wanted = format!("left out: {rest} image{s} of the same series ");
                assert!(said.contains(&wanted), "{what}: {said}");
                assert!(said.contains(&format!("{name} {} was broken off", whole + 1)), "{said}");
            }
        }
    }
}

#[test]
fn a_first_repeat_that_is_not_whole_is_left_out_as_a_last_one_is() {
    for lengths in [[1, 8, 8], [3, 8, 8]] {
        for (tag, vr) in [(TEMPORAL_POSITION, *b"IS"), (ACQUISITION_NUMBER, *b"IS")] {
            let (_folder, study) =
                parts(&lengths, |part, _, data| data.set_text(tag, vr, part + 1));
            assert_eq!(study.default().unwrap(), 1, "{tag:?}");
            assert_eq!(study.all(), [1, 2], "{tag:?}");
            for index in [1, 2] {
                assert_eq!(study.slices(index).len(), 8, "{tag:?}");
                assert_eq!(parts_of(&study, index), [index.to_string()], "{tag:?}");
                assert!(notes(&study, index).contains(" 1 was broken off"), "{tag:?}");
            }
        }
    }
}

#[test]
fn b_values_and_kernels_at_shifted_positions_are_never_interleaved() {
    let kernels: (Tag, _, [&str; 2]) = ((0x0018, 0x1210), *b"SH", ["B30f", "B70f"]);
    let b_values: (Tag, _, [&str; 2]) = ((0x0018, 0x9087), *b"FD", ["", ""]);
    for (tag, vr, values) in [kernels, b_values] {
        let (_folder, study) = parts(&[8, 8], |part, k, data| {
            match vr {
                [b'F', b'D'] => data.set(tag, vr, &(1000.0 * part as f64).to_le_bytes()),
                _ => data.set_text(tag, vr, values[part]),
            }
            place(data, 2.0 * k as f64 + part as f64);
        });
        assert_eq!(study.volumes.len(), 2, "{tag:?}");
        for index in 0..2 {
            assert_eq!(study.slices(index).len(), 8, "{tag:?}");
            assert_eq!(parts_of(&study, index), [index.to_string()], "{tag:?}");
        }
    }
}

#[test]
fn slices_that_no_whole_repeat_has_are_not_left_out_as_one_that_was_broken_off() {
    // The last two of eight slices lie beyond the seven that the first part has.
    let (_folder, study) = parts(&[7, 2], |part, k, data| {
        data.set_text(TEMPORAL_POSITION, *b"IS", part + 1);
        place(data, if part == 0 { k as f64 } else { 6.0 + k as f64 });
    });
    let error = study.open(0, &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::ConflictingSlices, "{error}");
}

#[test]
fn what_was_measured_is_the_default_before_what_was_made_of_it() {
    let cases: [(&[&str], usize); 5] = [
        (&["DERIVED\\PRIMARY\\AXIAL", "ORIGINAL\\PRIMARY\\AXIAL"], 1),
        (&["ORIGINAL\\PRIMARY\\I_FFE\\I\\FFE", "ORIGINAL\\PRIMARY\\M_FFE\\M\\FFE"], 1),
        (&["ORIGINAL\\PRIMARY\\P\\ND", "ORIGINAL\\PRIMARY\\M\\ND", "ORIGINAL\\PRIMARY\\R\\ND"], 1),
        (&["ORIGINAL\\PRIMARY\\IMAGINARY", "ORIGINAL\\PRIMARY\\MAGNITUDE"], 1),
        (
            &[
                "DERIVED\\PRIMARY\\DIXON\\FAT",
                "DERIVED\\PRIMARY\\DIXON\\IN",
                "DERIVED\\PRIMARY\\DIXON\\WATER",
            ],
            2,
        ),
    ];
    for (types, wanted) in cases {
        let (_folder, study) = parts(&vec![8; types.len()], |part, _, data| {
            data.set_text(IMAGE_TYPE, *b"CS", types[part]);
        });
        assert_eq!(study.volumes.len(), types.len(), "{types:?}");
        let index = study.default().unwrap();
        assert_eq!(parts_of(&study, index), [wanted.to_string()], "{types:?}");
        let choice = study.choice(index).unwrap().to_string();
        let meshed = choice.split(" is meshed").next().unwrap();
        assert!(meshed.contains(types[wanted]), "{choice}");
    }
}

/// Slices of one volume at one position each: what they are set to is no reason to take them apart.
#[test]
fn stations_packages_and_last_digits_take_no_volume_apart() {
    type Value = fn(usize) -> &'static str;
    let cases: [(&str, Tag, Value); 5] = [
        ("stations", ECHO_TIME, |k| if (8..16).contains(&k) { "12" } else { "5" }),
        ("stations in turn", TEMPORAL_POSITION, |k| ["1", "2"][k / 6 % 2]),
        ("the seam", TEMPORAL_POSITION, |k| ["1", "2"][usize::from(k > 11 || k == 10)]),
        ("last digits", ECHO_TIME, |k| ["10", "10.01"][k % 2]),
        ("packages of two", ECHO_TIME, |k| {
            ["30", "31", "32", "33", "34", "35", "36", "37", "38", "39", "40", "41"][k % 12]
        }),
    ];
    for (what, tag, value) in cases {
        let folder = TempDir::new().unwrap();
        Series::axial(24).write_as(&folder.path().join("0"), EXPLICIT, |k, data| {
            data.set_text(tag, *b"DS", value(k));
        });
        let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
        let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
        assert_eq!(volume.meta.grid.dims.nz(), 24, "{what}");
        assert_eq!(notes(&study, study.default().unwrap()), "", "{what}");
    }
}

#[test]
fn a_slice_that_is_written_otherwise_breaks_no_whole_repeat_off() {
    for (tag, odd) in [(ECHO_TIME, "20.01"), (TEMPORAL_POSITION, "4"), (ACQUISITION_NUMBER, "7")] {
        let (_folder, study) = parts(&[8, 8], |part, k, data| {
            let value = ["1", "2"][part];
            data.set_text(tag, *b"DS", if (part, k) == (1, 3) { odd } else { value });
        });
        let first = study.default().unwrap();
        for index in [first, first + 1] {
            let volume = study.open(index, &OpenOptions::default()).unwrap();
            assert_eq!(volume.meta.grid.dims.nz(), 8, "{tag:?}");
            assert!(!notes(&study, index).contains("broken off"), "{tag:?}");
        }
    }
}

#[test]
fn tables_that_go_to_and_fro_may_share_a_slice() {
    let (_folder, study) = parts(&[8, 8, 8, 8], |part, k, data| {
        data.set_text(TEMPORAL_POSITION, *b"IS", part + 1);
        place(data, 2.0 * (k + 7 * (part % 2)) as f64);
    });
    for index in 0..4 {
        let volume = study.open(index, &OpenOptions::default()).unwrap();
        assert_eq!(volume.meta.grid.dims.nz(), 8);
    }
}

#[test]
fn a_slice_of_another_study_is_named_where_it_is_left_out() {
    let folder = TempDir::new().unwrap();
    Series::axial(8).write_as(&folder.path().join("0"), EXPLICIT, |k, data| {
        data.set_text((0x0020, 0x000D), *b"UI", if k == 7 { "1.2.3.5" } else { "1.2.3.4" });
    });
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let said = notes(&study, study.default().unwrap());
    assert!(said.contains("left out: 1 image of the same series"), "{said}");
    assert!(said.contains("another StudyInstanceUID"), "{said}");
}

#[test]
fn echoes_of_a_slice_may_share_the_study_that_each_slice_has_of_its_own() {
    let (_folder, study) = parts(&[8, 8], |part, k, data| {
        data.set_text((0x0020, 0x000D), *b"UI", format!("1.2.3.{}", k + 1));
        data.set_text(ECHO_TIME, *b"DS", 5 * (part + 1));
    });
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    assert_eq!(volume.meta.grid.dims.nz(), 8);
}
