//! Where slices lie that do not say it in the usual place, and what is said where they do not say
//! it at all.

use mcubes::error::Kind;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study, What};
use tempfile::TempDir;

use crate::dicom_enhanced::enhanced;
use crate::support::dicom::{EXPLICIT, Elements, PIXELS, Series, file};

type Tag = (u16, u16);

const CLASS: Tag = (0x0008, 0x0016);
const SPACING_BETWEEN_SLICES: Tag = (0x0018, 0x0088);
const STUDY: Tag = (0x0020, 0x000D);
const SERIES: Tag = (0x0020, 0x000E);
const POSITION: Tag = (0x0020, 0x0032);
const ORIENTATION: Tag = (0x0020, 0x0037);
const NUCLEAR: &str = "1.2.840.10008.5.1.4.1.1.20";

/// A series of eight slices, each changed first.
fn series(edit: impl Fn(usize, &mut Elements)) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    Series::axial(8).write_as(folder.path(), EXPLICIT, edit);
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    (folder, study)
}

/// One file of four frames without functional groups.
fn frames(edit: impl Fn(&mut Elements)) -> (TempDir, Study) {
    let mut data = Elements::default();
    data.text(CLASS, *b"UI", "1.2.840.10008.5.1.4.1.1.2");
    data.text(SERIES, *b"UI", "1.2.3");
    data.text((0x0028, 0x0008), *b"IS", "4");
    for (element, value) in [(0x10, 2), (0x11, 2), (0x100, 8), (0x101, 8), (0x102, 7), (0x103, 0)] {
        data.short((0x0028, element), value);
    }
    data.element(PIXELS, *b"OB", &[0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
    text(&mut data, (0x0028, 0x0030), *b"DS", "1\\1");
    edit(&mut data);
    one_file(&data)
}

fn one_file(data: &Elements) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("m.dcm");
    std::fs::write(&path, file(EXPLICIT, data)).unwrap();
    let study = dicom::scan(&path, &ScanOptions::default()).unwrap();
    (folder, study)
}

fn text(data: &mut Elements, tag: Tag, vr: [u8; 2], value: &str) {
    data.set(tag, vr, value.as_bytes());
}

fn place(data: &mut Elements, z: f64) {
    text(data, POSITION, *b"DS", &format!("0\\0\\{z}"));
    text(data, ORIENTATION, *b"DS", "1\\0\\0\\0\\1\\0");
}

/// Moves the position and the orientation into the `DetectorInformationSequence`.
fn detect(data: &mut Elements) {
    text(data, CLASS, *b"UI", NUCLEAR);
    let mut item = Elements::default();
    for tag in [POSITION, ORIENTATION] {
        item.element(tag, *b"DS", data.value(tag));
        data.remove(tag);
    }
    let mut sequence = Elements::default();
    sequence.sequence((0x0054, 0x0022), &[item]);
    data.set((0x0054, 0x0022), *b"SQ", &sequence.0[12..]);
}

fn refusal(study: &Study) -> String {
    let error = study.open(0, &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::UnfitSeries, "{error}");
    error.to_string()
}

/// The place of the first slice, the step to the next, and how many there are.
fn placed(study: &Study) -> (f64, f64, usize) {
    assert_eq!(study.volumes.len(), 1);
    let grid = study.open(0, &OpenOptions::default()).unwrap().meta.grid;
    let at = |k| grid.affine.apply([0.0, 0.0, k])[2];
    (at(0.0), at(1.0) - at(0.0), grid.dims.nz())
}

#[test]
fn images_of_nuclear_medicine_lie_where_their_detector_says() {
    let (_folder, study) = series(|k, data| {
        place(data, 30.0 + 2.0 * k as f64);
        detect(data);
    });
    assert_eq!(placed(&study), (30.0, 2.0, 8));
}

#[test]
fn frames_of_nuclear_medicine_step_by_spacing_between_slices_or_say_that_it_is_absent() {
    for in_sequence in [true, false] {
        for step in [Some("2.5"), None, Some("unknown"), Some("0")] {
            let (_folder, study) = frames(|data| {
                text(data, CLASS, *b"UI", NUCLEAR);
                place(data, 30.0);
                if let Some(step) = step {
                    text(data, SPACING_BETWEEN_SLICES, *b"DS", step);
                }
                if in_sequence {
                    detect(data);
                }
            });
            if step == Some("2.5") {
                assert_eq!(placed(&study), (30.0, 2.5, 4));
            } else {
                let line = refusal(&study);
                assert!(line.contains("no SpacingBetweenSlices"), "{line}");
                assert!(!line.contains("ImagePositionPatient"), "{line}");
            }
        }
    }
}

#[test]
fn frames_that_share_one_position_are_refused_for_that() {
    for step in [None, Some("2")] {
        let (_folder, study) = frames(|data| {
            place(data, 30.0);
            if let Some(step) = step {
                text(data, SPACING_BETWEEN_SLICES, *b"DS", step);
            }
        });
        let line = refusal(&study);
        assert!(line.contains("one ImagePositionPatient for all frames of the file"), "{line}");
    }
}

#[test]
fn a_study_uid_of_its_own_in_each_image_is_no_study_of_its_own() {
    let (_folder, study) = series(|k, data| text(data, STUDY, *b"UI", &format!("1.2.3.{k}")));
    assert_eq!(study.volumes.len(), 1);
    let volume = study.open(0, &OpenOptions::default()).unwrap();
    assert_eq!(volume.meta.grid.dims.nz(), 8);
    let said: Vec<String> = volume.meta.notes.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|n| n.contains("StudyInstanceUID of its own")), "{said:?}");
}

#[test]
fn two_images_of_two_studies_are_told_apart_by_name() {
    let folder = TempDir::new().unwrap();
    Series::axial(2).write_as(folder.path(), EXPLICIT, |k, data| {
        text(data, STUDY, *b"UI", &format!("1.2.3.{k}"));
    });
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let line = refusal(&study);
    assert!(line.contains("another StudyInstanceUID"), "{line}");
}

#[test]
fn a_stack_of_each_frame_is_no_stack_of_its_own() {
    let stacked = |stack: fn(usize) -> usize| {
        let frames: Vec<(usize, usize)> = (0..8).map(|k| (k, k)).collect();
        one_file(&enhanced(&frames, |_, k, item| {
            let mut content = Elements::default();
            content.text((0x0020, 0x9056), *b"SH", &stack(k).to_string());
            item.sequence((0x0020, 0x9111), &[content]);
        }))
    };
    let (_folder, study) = stacked(|k| k + 1);
    assert_eq!(placed(&study).2, 8);
    let (_folder, study) = stacked(|k| k / 4);
    assert_eq!(study.volumes.len(), 2);
}

#[test]
fn spectra_are_set_aside() {
    let (folder, _) = series(|_, _| {});
    let mut data = Elements::default();
    data.text(CLASS, *b"UI", "1.2.840.10008.5.1.4.1.1.4.2");
    data.text(SERIES, *b"UI", "1.2.3");
    data.short((0x0028, 0x0010), 1);
    data.short((0x0028, 0x0011), 1);
    data.element((0x5600, 0x0020), *b"OF", &[0; 64]);
    std::fs::write(folder.path().join("spectrum"), file(EXPLICIT, &data)).unwrap();
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    assert_eq!((study.volumes.len(), study.faults.len()), (1, 0));
    assert!(study.stray_faults().is_empty());
    let aside: Vec<_> = study.set_aside.iter().map(|a| (a.what, a.what.name(a.count))).collect();
    assert_eq!(aside, [(What::Spectroscopy, "spectroscopy object")]);
}
