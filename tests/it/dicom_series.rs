//! Which images are slices of one volume: what a header leaves out or writes in another way splits
//! no series, and what does split one is named.

use std::path::Path;

use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study, What};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{EXPLICIT, Elements, Series};

const N_SLICES: usize = 9;

const FRAME_OF_REFERENCE: (u16, u16) = (0x0020, 0x0052);
const MODALITY: (u16, u16) = (0x0008, 0x0060);

fn scan(folder: &Path) -> Study {
    dicom::scan(folder, &ScanOptions::default()).unwrap()
}

/// Axial slices whose files are changed by `edit`, which is told the number of the slice.
fn edited(edit: impl Fn(usize, &mut Vec<u8>)) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    let series = Series::axial(N_SLICES);
    for k in 0..N_SLICES {
        let mut bytes = series.image(k, k + 1);
        edit(k, &mut bytes);
        std::fs::write(folder.path().join(format!("S{k}")), bytes).unwrap();
    }
    let study = scan(folder.path());
    (folder, study)
}

/// Where an element with a short length begins, and where its value does and ends.
fn element(bytes: &[u8], (group, element): (u16, u16)) -> (usize, std::ops::Range<usize>) {
    let tag = [group.to_le_bytes(), element.to_le_bytes()].concat();
    let at = bytes.windows(4).position(|w| w == tag).unwrap();
    let length = usize::from(u16::from_le_bytes([bytes[at + 6], bytes[at + 7]]));
    (at, at + 8..at + 8 + length)
}

fn remove(bytes: &mut Vec<u8>, tag: (u16, u16)) {
    let (at, value) = element(bytes, tag);
    bytes.drain(at..value.end);
}

fn notes(study: &Study, index: usize) -> Vec<String> {
    study.volumes[index].meta.as_ref().unwrap().notes.iter().map(ToString::to_string).collect()
}

#[test]
fn slices_without_a_frame_of_reference_or_modality_belong_to_their_series() {
    for tag in [FRAME_OF_REFERENCE, MODALITY] {
        let lose = |k: usize, bytes: &mut Vec<u8>| {
            if k.is_multiple_of(2) {
                remove(bytes, tag);
            }
        };
        let (_folder, study) = edited(lose);
        assert_eq!(study.volumes.len(), 1, "{tag:?}");
        assert_eq!(study.volumes[0].dims[2], N_SLICES, "{tag:?}");
        assert_eq!(study.volumes[0].modality.as_deref(), Some("CT"), "{tag:?}");
        assert_eq!(notes(&study, 0), [""; 0], "{tag:?}");
    }
}

/// 0xFFFB is -5 as a signed number and 65531 as an unsigned one; the slope is 0.25, the intercept
/// -100.
fn sign(bytes: &mut [u8], is_signed: bool) {
    let first_sample = bytes.len() - 2 * 40 * 36;
    bytes[first_sample..first_sample + 2].copy_from_slice(&[0xFB, 0xFF]);
    let (_, value) = element(bytes, (0x0028, 0x0103));
    bytes[value.start] = u8::from(is_signed);
}

const SIGNED: f64 = -5.0 * 0.25 - 100.0;
const UNSIGNED: f64 = 65531.0 * 0.25 - 100.0;

#[test]
fn slices_that_differ_in_pixel_representation_are_each_read_by_their_own() {
    let (_folder, study) = edited(|k, bytes| sign(bytes, k % 2 == 1));
    assert_eq!(study.volumes.len(), 1);
    let found = values(study.open(0, &OpenOptions::default()).unwrap()).unwrap();
    let firsts: Vec<f64> = found.iter().step_by(40 * 36).copied().collect();
    let wanted = |k| if k % 2 == 1 { SIGNED } else { UNSIGNED };
    assert_eq!(firsts, (0..N_SLICES).map(wanted).collect::<Vec<_>>());
}

#[test]
fn signed_and_unsigned_images_at_the_same_positions_are_two_volumes() {
    let (folder, _) = edited(|_, bytes| sign(bytes, true));
    let series = Series::axial(N_SLICES);
    for k in 0..N_SLICES {
        let mut bytes = series.image(k, k + 1);
        sign(&mut bytes, false);
        std::fs::write(folder.path().join(format!("U{k}")), bytes).unwrap();
    }
    let study = scan(folder.path());
    let mut firsts = Vec::new();
    for index in 0..study.volumes.len() {
        assert_eq!(study.volumes[index].dims[2], N_SLICES);
        let found = values(study.open(index, &OpenOptions::default()).unwrap()).unwrap();
        firsts.extend(found.first().copied());
    }
    assert_eq!(firsts, [SIGNED, UNSIGNED]);
}

#[test]
fn the_note_on_images_left_out_names_what_they_differ_in() {
    let another = |bytes: &mut Vec<u8>, tag| {
        let (_, value) = element(bytes, tag);
        bytes[value.start + 1] = b'R';
    };
    let (_folder, study) = edited(|k, bytes| {
        if k == N_SLICES - 1 {
            another(bytes, MODALITY);
        }
    });
    let said = notes(&study, study.default().unwrap());
    assert_eq!(said, ["left out: 1 image of the same series (S8): another Modality"]);
    let (_folder, study) = edited(|k, bytes| {
        if k == 0 {
            let (_, value) = element(bytes, FRAME_OF_REFERENCE);
            bytes[value.end - 2] = b'8';
        }
        if k == N_SLICES - 1 {
            remove(bytes, (0x0020, 0x0032));
        }
    });
    let said = notes(&study, study.default().unwrap());
    let reasons = "another FrameOfReferenceUID, no ImagePositionPatient";
    assert_eq!(said, [format!("left out: 2 images of the same series (S0): {reasons}")]);
}

#[test]
fn secondary_captures_are_slices_where_each_says_where_it_lies_and_there_is_nothing_else() {
    let capture = |data: &mut Elements| {
        data.set_text((0x0008, 0x0016), *b"UI", "1.2.840.10008.5.1.4.1.1.7");
    };
    let folder = TempDir::new().unwrap();
    let captures = Series { uid: "1.2.4".to_owned(), ..Series::axial(N_SLICES) };
    captures.write_as(&folder.path().join("a"), EXPLICIT, |_, data| capture(data));
    let study = scan(folder.path());
    assert_eq!(study.volumes.len(), 1);
    let (_plain, plain) = edited(|_, _| {});
    let of = |study: &Study| values(study.open(0, &OpenOptions::default()).unwrap()).unwrap();
    assert_eq!(of(&study), of(&plain));
    assert!(notes(&study, 0).iter().any(|n| n.starts_with("secondary captures")));

    Series::axial(3).write_as(&folder.path().join("b"), EXPLICIT, |_, _| {});
    let study = scan(folder.path());
    let aside: Vec<_> = study.set_aside.iter().map(|a| (a.what, a.count)).collect();
    assert_eq!(aside, [(What::SecondaryCapture, N_SLICES)]);
    assert_eq!((study.volumes.len(), study.slices(0).len()), (1, 3));

    let folder = TempDir::new().unwrap();
    Series::axial(N_SLICES).write_as(folder.path(), EXPLICIT, |_, data| {
        capture(data);
        data.remove((0x0020, 0x0037));
    });
    assert!(scan(folder.path()).volumes.is_empty());
}
