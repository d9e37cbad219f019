//! UIDs that each image has one of its own of, as careless anonymisers make them: dcm2niix takes such
//! images for the volume that they are, and so does SimpleITK where they have one series.

use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{EXPLICIT, Elements, Series};

type Tag = (u16, u16);

const STUDY: Tag = (0x0020, 0x000D);
const SERIES: Tag = (0x0020, 0x000E);
const SERIES_NUMBER: Tag = (0x0020, 0x0011);
const POSITION: Tag = (0x0020, 0x0032);
const FRAME_OF_REFERENCE: Tag = (0x0020, 0x0052);
const N_SLICES: usize = 12;

/// Slices of a study and a series with a number, each changed first.
fn series(edit: impl Fn(usize, &mut Elements)) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    Series::axial(N_SLICES).write_as(folder.path(), EXPLICIT, |k, data| {
        data.set_text(STUDY, *b"UI", "1.2.3.4");
        data.set_text(SERIES_NUMBER, *b"IS", 7);
        edit(k, data);
    });
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    (folder, study)
}

fn only_values(study: &Study) -> Vec<f64> {
    assert_eq!(study.volumes.len(), 1);
    values(study.open(0, &OpenOptions::default()).unwrap()).unwrap()
}

fn own(tag: Tag) -> impl Fn(usize, &mut Elements) {
    move |k, data| data.set_text(tag, *b"UI", format!("1.2.3.{}", k + 100))
}

#[test]
fn uids_of_its_own_in_each_image_set_no_slice_apart_and_are_told_of() {
    let plain = only_values(&series(|_, _| {}).1);
    for (tag, name) in [
        (STUDY, "StudyInstanceUID"),
        (SERIES, "SeriesInstanceUID"),
        (FRAME_OF_REFERENCE, "FrameOfReferenceUID"),
    ] {
        let (_folder, study) = series(own(tag));
        assert_eq!(only_values(&study), plain, "{name}");
        let notes = &study.volumes[0].meta.as_ref().unwrap().notes;
        let wanted = format!("each image has a {name} of its own");
        assert!(notes.iter().any(|n| n.to_string().starts_with(&wanted)), "{name}");
    }
    for tag in [STUDY, SERIES] {
        let (_folder, study) = series(|k, data| {
            own(tag)(k, data);
            own(FRAME_OF_REFERENCE)(k, data);
        });
        assert_eq!(only_values(&study), plain, "{tag:?}");
    }
}

#[test]
fn a_few_images_that_share_a_frame_of_reference_leave_no_two_of_them_as_the_volume() {
    let (_folder, study) = series(|k, data| {
        let k = if k == 3 { 9 } else { k };
        own(FRAME_OF_REFERENCE)(k, data);
    });
    assert_eq!(only_values(&study), only_values(&series(|_, _| {}).1));
}

#[test]
fn two_frames_of_reference_are_two_places() {
    let (_folder, study) = series(|k, data| own(FRAME_OF_REFERENCE)(k / 6, data));
    assert_eq!(study.volumes.len(), 2);
    let (_folder, study) = series(|k, data| own(FRAME_OF_REFERENCE)(k / 2, data));
    assert_eq!(study.volumes.len(), 6);
}

#[test]
fn series_of_one_image_each_are_one_only_where_all_else_that_names_it_is_the_same() {
    type Edit = fn(usize, &mut Elements);
    let edits: [Edit; 4] = [
        |k, data| data.set_text(SERIES_NUMBER, *b"IS", k + 1),
        |_, data| data.remove(SERIES_NUMBER),
        own_study,
        |_, data| data.remove(POSITION),
    ];
    for (n, edit) in edits.into_iter().enumerate() {
        let (_folder, study) = series(|k, data| {
            own(SERIES)(k, data);
            edit(k, data);
        });
        assert_eq!(study.volumes.len(), N_SLICES, "{n}");
    }
}

fn own_study(k: usize, data: &mut Elements) {
    own(STUDY)(k, data);
}
