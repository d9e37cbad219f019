//! Multi-frame files with functional groups: each frame has its own item, and the dimensions that
//! the file counts tell frames at one position apart, in whatever order they are stored.

use mcubes::error::Kind;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Study};
use tempfile::TempDir;

use crate::support::dicom::{EXPLICIT, Elements, PIXELS, file};

type Tag = (u16, u16);

const N_SLICES: usize = 10;

/// A file of two phases, whose frames stand in a scrambled order: by which attributes a frame
/// tells its phase is asked for.
fn two_phases(groups: impl Fn(usize, usize, &mut Elements)) -> Elements {
    let frames: Vec<(usize, usize)> =
        (0..2 * N_SLICES).map(|n| (n * 7 + 3) % (2 * N_SLICES)).map(|n| (n % 2, n / 2)).collect();
    enhanced(&frames, groups)
}

/// A file with a frame for each phase and slice given; the samples are the phase.
pub(crate) fn enhanced(
    frames: &[(usize, usize)],
    groups: impl Fn(usize, usize, &mut Elements),
) -> Elements {
    let mut orientation = Elements::default();
    orientation.text((0x0020, 0x0037), *b"DS", "1\\0\\0\\0\\1\\0");
    let mut measures = Elements::default();
    measures.text((0x0028, 0x0030), *b"DS", "1\\1");
    let mut shared = Elements::default();
    shared.sequence((0x0020, 0x9116), &[orientation]);
    shared.sequence((0x0028, 0x9110), &[measures]);
    let own = |&(phase, k): &(usize, usize)| {
        let mut item = Elements::default();
        let mut position = Elements::default();
        position.text((0x0020, 0x0032), *b"DS", &format!("0\\0\\{}", k as f64 * 1.8));
        item.sequence((0x0020, 0x9113), &[position]);
        groups(phase, k, &mut item);
        item
    };
    let own: Vec<Elements> = frames.iter().map(own).collect();
    let mut data = Elements::default();
    data.text((0x0008, 0x0016), *b"UI", "1.2.840.10008.5.1.4.1.1.4.1");
    data.text((0x0008, 0x0060), *b"CS", "MR");
    data.text((0x0020, 0x000E), *b"UI", "1.2.826.0.1.3680043.9.7.77");
    data.short((0x0028, 0x0002), 1);
    data.text((0x0028, 0x0004), *b"CS", "MONOCHROME2");
    data.text((0x0028, 0x0008), *b"IS", &frames.len().to_string());
    data.short((0x0028, 0x0010), 2);
    data.short((0x0028, 0x0011), 2);
    data.short((0x0028, 0x0100), 8);
    data.short((0x0028, 0x0101), 8);
    data.short((0x0028, 0x0102), 7);
    data.short((0x0028, 0x0103), 0);
    data.sequence((0x5200, 0x9229), &[shared]);
    data.sequence((0x5200, 0x9230), &own);
    let pixels: Vec<u8> = frames.iter().flat_map(|&(phase, _)| [phase as u8; 4]).collect();
    data.element(PIXELS, *b"OB", &pixels);
    data
}

fn scan(data: &Elements) -> (TempDir, Study) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("e.dcm");
    std::fs::write(&path, file(EXPLICIT, data)).unwrap();
    let study = dicom::scan(&path, &ScanOptions::default()).unwrap();
    (folder, study)
}

fn assert_two_phases(data: &Elements, what: &str) {
    let (_folder, study) = scan(data);
    assert_eq!(study.volumes.len(), 2, "{what}");
    for index in 0..2 {
        let volume = study.open(index, &OpenOptions::default()).unwrap();
        let values = crate::dicom::values(volume).unwrap();
        assert_eq!(values.len(), 4 * N_SLICES, "{what}");
        assert!(values.iter().all(|&v| v == values[0]), "{what}: {values:?}");
    }
}

#[test]
fn dimension_indexes_tell_frames_at_one_position_apart() {
    // The position may be counted first or last; the stack comes first.
    for position_first in [true, false] {
        let data = two_phases(|phase, k, item| {
            let index = if position_first { [k, phase] } else { [phase, k] };
            let mut content = Elements::default();
            let [a, b] = index.map(|n| (n as u32 + 1).to_le_bytes());
            let value = [1_u32.to_le_bytes(), a, b].concat();
            content.element((0x0020, 0x9157), *b"UL", &value);
            item.sequence((0x0020, 0x9111), &[content]);
        });
        assert_two_phases(&data, &format!("position first: {position_first}"));
    }
}

#[test]
fn functional_groups_tell_frames_at_one_position_apart() {
    let cases: [(Tag, Tag, [u8; 2]); 6] = [
        ((0x0018, 0x9118), (0x0020, 0x9153), *b"FD"),
        ((0x0020, 0x9310), (0x0020, 0x930D), *b"FD"),
        ((0x0018, 0x9115), (0x0018, 0x9079), *b"FD"),
        ((0x0018, 0x9325), (0x0018, 0x0060), *b"DS"),
        ((0x0018, 0x9314), (0x0018, 0x1210), *b"SH"),
        ((0x0020, 0x9111), (0x0020, 0x9156), *b"US"),
    ];
    for (sequence, tag, vr) in cases {
        let data = two_phases(|phase, _, item| {
            let mut group = Elements::default();
            match &vr {
                b"FD" => group.element(tag, vr, &(phase as f64 * 30.0).to_le_bytes()),
                b"US" => group.short(tag, phase as u16 + 1),
                _ => group.text(tag, vr, ["80", "140"][phase]),
            }
            item.sequence(sequence, &[group]);
        });
        assert_two_phases(&data, &format!("{sequence:?}"));
    }
}

#[test]
fn gradient_directions_tell_frames_at_one_position_apart() {
    let data = two_phases(|phase, _, item| {
        let mut direction = Elements::default();
        let vector: [f64; 3] = if phase == 0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        direction.element((0x0018, 0x9089), *b"FD", &vector.map(f64::to_le_bytes).concat());
        let mut diffusion = Elements::default();
        diffusion.sequence((0x0018, 0x9076), &[direction]);
        item.sequence((0x0018, 0x9117), &[diffusion]);
    });
    assert_two_phases(&data, "gradients");
}

#[test]
fn a_file_without_an_item_for_each_frame_is_refused() {
    for claimed in [N_SLICES - 1, N_SLICES + 1] {
        let frames: Vec<(usize, usize)> = (0..N_SLICES).map(|k| (0, k)).collect();
        let mut data = enhanced(&frames, |_, _, _| {});
        data.set((0x0028, 0x0008), *b"IS", claimed.to_string().as_bytes());
        data.set(PIXELS, *b"OB", &vec![0; 4 * claimed]);
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("e.dcm");
        std::fs::write(&path, file(EXPLICIT, &data)).unwrap();
        let study = dicom::scan(&path, &ScanOptions::default());
        if claimed < N_SLICES {
            // Cut short, as pydicom's liver_1frame.dcm is.
            let study = study.unwrap();
            assert_eq!(study.volumes[study.default().unwrap()].dims[2], claimed);
            continue;
        }
        let error = study.and_then(|s| s.default()).err().unwrap();
        assert_eq!(error.kind(), Kind::BadHeader, "{error}");
        let line = error.to_string();
        assert!(line.contains(&format!("NumberOfFrames is {claimed}")), "{line}");
        assert!(line.contains("has 10 items"), "{line}");
    }
}

#[test]
fn a_frame_that_is_left_out_is_named() {
    let frames: Vec<(usize, usize)> = (0..N_SLICES).map(|k| (0, k)).collect();
    let mut data = enhanced(&frames, |_, _, _| {});
    // The last position becomes an element that is not read.
    let at = data.0.windows(4).rposition(|w| w == [0x20, 0, 0x32, 0]).unwrap();
    data.0[at + 2] = 0x31;
    let (_folder, study) = scan(&data);
    let notes = &study.volumes[study.default().unwrap()].meta.as_ref().unwrap().notes;
    let said: Vec<String> = notes.iter().map(ToString::to_string).collect();
    let wanted = "left out: 1 image of the same series (frame 10): no ImagePositionPatient";
    assert_eq!(said, [wanted]);
}

#[test]
fn frames_that_all_lie_at_one_position_are_no_volume() {
    let frames: Vec<(usize, usize)> = (0..N_SLICES).map(|k| (k, 0)).collect();
    let data = enhanced(&frames, |phase, _, item| {
        let mut content = Elements::default();
        content.element((0x0020, 0x9157), *b"UL", &(phase as u32 + 1).to_le_bytes());
        item.sequence((0x0020, 0x9111), &[content]);
    });
    let (_folder, study) = scan(&data);
    let error = study.default().err().unwrap().to_string();
    assert!(error.contains("all 10 images lie at one position"), "{error}");
}
