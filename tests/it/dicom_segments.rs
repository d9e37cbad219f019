//! DICOM segmentations: frames without a sample of the segment may be left out (PS3.3, C.8.20.2),
//! and what is not stored is empty.

use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Selector, Study, What};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::Series;
use crate::support::segments::{Measures, STEP, Segmentation};

/// The one file as a study.
fn scan(segmentation: &Segmentation) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("seg.dcm");
    std::fs::write(&path, segmentation.file()).unwrap();
    let study = dicom::scan(&path, &ScanOptions::default()).unwrap();
    (folder, study)
}

/// What segment 1 looks like from its first slice stored to its last.
fn expected(slices: &[usize]) -> Vec<f64> {
    let (first, last) = (slices[0], slices[slices.len() - 1]);
    let empty = || vec![0.0; Segmentation::plane(1, 0).len()];
    (first..=last)
        .flat_map(|k| if slices.contains(&k) { Segmentation::plane(1, k) } else { empty() })
        .collect()
}

fn assert_filled(slices: &[usize], measures: Measures) {
    let frames: Vec<(u16, usize)> = slices.iter().map(|&k| (1, k)).collect();
    let (_folder, study) = scan(&Segmentation::binary(&frames, measures));
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    let steps = volume.meta.grid.affine.rows()[2][2];
    assert!((steps - STEP).abs() < 1e-9, "{slices:?} {measures:?}: the step is {steps} mm");
    assert!(volume.meta.gaps_mm.is_none(), "{slices:?} {measures:?}");
    assert_eq!(values(volume).unwrap(), expected(slices), "{slices:?} {measures:?}");
}

#[test]
fn slices_left_out_of_a_segmentation_are_empty_however_far_apart_the_others_are() {
    for measures in [Measures::Shared, Measures::PerFrame] {
        assert_filled(&[5, 12, 19], measures);
        assert_filled(&[5, 12, 20], measures);
        assert_filled(&[6, 8, 10, 12, 14], measures);
        assert_filled(&[3, 4, 9], measures);
    }
}

#[test]
fn without_spacing_between_slices_the_narrowest_gap_is_the_step() {
    assert_filled(&[3, 4, 9], Measures::Absent);
}

#[test]
fn a_spacing_between_slices_that_the_positions_contradict_is_not_the_step() {
    // Some gap is no multiple of it within a few per cent.
    for wrong in [STEP / 1.8, STEP / 1.4, STEP * 0.8, STEP * 1.2, STEP * 2.0] {
        assert_filled(&[5, 6, 7, 8, 9], Measures::Says(wrong));
        assert_filled(&[5, 6, 7, 11, 12], Measures::Says(wrong));
    }
    // Written with two digits.
    assert_filled(&[5, 12, 19], Measures::Says(2.52));
}

#[test]
fn a_segment_of_one_slice_is_a_plane_where_its_step_is_given_and_is_said_to_be_flat() {
    for measures in [Measures::Shared, Measures::PerFrame] {
        assert_filled(&[7], measures);
        let (_folder, study) = scan(&Segmentation::binary(&[(1, 7)], measures));
        let volume = study.open(0, &OpenOptions::default()).unwrap();
        assert!(volume.meta.notes.iter().any(|note| note.to_string().contains("flat")));
    }
    let (_folder, study) = scan(&Segmentation::binary(&[(1, 7)], Measures::Absent));
    let error = study.open(0, &OpenOptions::default()).err().unwrap();
    assert!(error.to_string().contains("a single image is no volume"), "{error}");
}

#[test]
fn the_first_segment_is_the_first_volume_and_the_default_however_the_frames_are_ordered() {
    // The second segment has more slices, and the first frame of the file.
    let frames = [(10, 4), (2, 3), (10, 3), (1, 5), (2, 4), (2, 2), (1, 4), (10, 2)];
    let (_folder, study) = scan(&Segmentation::binary(&frames, Measures::Shared));
    let apart: Vec<_> = study.volumes.iter().filter_map(|v| v.apart.as_deref()).collect();
    assert_eq!(apart, ["segment 1", "segment 2", "segment 10"]);
    assert_eq!(study.default().unwrap(), 0);
    assert_eq!(study.volumes[0].dims[2], 2);
    let uid = study.volumes[0].series.uid.clone();
    assert_eq!(study.choose(&Selector::Uid(uid)).unwrap(), 0);
}

#[test]
fn a_label_map_is_a_segmentation_and_not_chosen_beside_images() {
    let folder = TempDir::new().unwrap();
    let images = Series::axial(5);
    images.write(folder.path());
    let label_map = Segmentation::label_map(20).file();
    std::fs::write(folder.path().join("labels"), &label_map).unwrap();
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    assert_eq!(study.volumes.len(), 2);
    assert_eq!(study.volumes[study.default().unwrap()].series.uid, images.uid);
    assert_eq!(study.all(), [study.default().unwrap()]);
    // By itself it is the volume, in whatever colours its labels are to be shown.
    for photometric in ["MONOCHROME2", "PALETTE COLOR"] {
        let (_folder, study) = scan(&Segmentation { photometric, ..Segmentation::label_map(20) });
        assert_eq!(study.volumes[study.default().unwrap()].dims[2], 20);
    }
    // Other pictures by a palette are colour pictures.
    let binary = Segmentation::binary(&[(1, 0), (1, 1)], Measures::Shared);
    let (_folder, study) = scan(&Segmentation { photometric: "PALETTE COLOR", ..binary });
    assert_eq!((study.volumes.len(), study.set_aside[0].what), (0, What::Colour));
}
