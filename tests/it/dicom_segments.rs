//! DICOM segmentations: frames without a sample of the segment may be left out (PS3.3, C.8.20.2),
//! and what is not stored is empty.

use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use tempfile::TempDir;

use crate::dicom::values;
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
fn a_segment_of_one_slice_is_as_thick_as_spacing_between_slices_says() {
    assert_filled(&[7], Measures::Shared);
    assert_filled(&[7], Measures::PerFrame);
}
