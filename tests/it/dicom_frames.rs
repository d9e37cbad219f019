//! The frames of compressed files: large ones, and components that are not whole.

use mcubes::Error;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use mcubes::source::survey;
use tempfile::TempDir;

use crate::support::dicom::Series;
use crate::support::repository;

const J2K: &str = "1.2.840.10008.1.2.4.90";

/// Three slices of 2912 rows and columns with the same JPEG 2000 codestream.
fn large(image: &[u8]) -> TempDir {
    let series = Series { rows: 2, cols: 2, ..Series::axial(3) };
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), J2K, |_, data| {
        for tag in [0x0010, 0x0011] {
            data.set((0x0028, tag), *b"US", &2912_u16.to_le_bytes());
        }
        data.set_image(image);
    });
    folder
}

#[test]
fn a_large_frame_that_is_mostly_one_value_is_decoded_however_small_it_is() {
    let image = std::fs::read(repository("testdata/j2k/blank-2912.j2k")).unwrap();
    assert!(image.len() * 64 < 2912 * 2912 * 2);
    let folder = large(&image);
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let volume = study.open(0, &OpenOptions::default()).unwrap();
    let survey = survey(volume, &mcubes::cancel::Cancel::new()).unwrap();
    // 0 and 1000, with a slope of 0.25 and an intercept of -100.
    assert_eq!(survey.range, Some((-100.0, 150.0)));
}

#[test]
fn a_component_of_fewer_samples_than_the_image_is_refused_by_name() {
    let mut image = std::fs::read(repository("testdata/j2k/blank-2912.j2k")).unwrap();
    // XRsiz, of the first component.
    image[43] = 2;
    let folder = large(&image);
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let volume = study.open(0, &OpenOptions::default()).unwrap();
    let error = survey(volume, &mcubes::cancel::Cancel::new()).unwrap_err();
    let error = Error::at(folder.path(), error).to_string();
    assert!(error.contains("every 2 x 1 samples (XRsiz, YRsiz) is not read"), "{error}");
}
