//! Files whose writers were careless where nothing is in doubt: they are read as pydicom and
//! SimpleITK read them.

use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use tempfile::TempDir;

use crate::dicom::values;
use crate::dicom_enhanced::enhanced;
use crate::support::dicom::{EXPLICIT, Elements, Series, file};

const ITEM: [u8; 4] = [0xFE, 0xFF, 0x00, 0xE0];
const ITEM_END: [u8; 8] = [0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0];
const SEQUENCE_END: [u8; 8] = [0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0];
const OPEN: [u8; 4] = [0xFF; 4];

/// The values of a series of three slices whose files are written by `write`.
fn written(write: impl Fn(usize, Elements) -> Vec<u8>) -> Result<Vec<f64>, String> {
    let folder = TempDir::new().unwrap();
    let series = Series::axial(3);
    for k in 0..3 {
        let image = series.image(k, k + 1);
        // Preamble, mark, the length of the meta group in an element of 12 bytes, the group.
        let meta = u32::from_le_bytes(image[140..144].try_into().unwrap()) as usize;
        let data = Elements(image[144 + meta..].to_vec());
        std::fs::write(folder.path().join(k.to_string()), write(k, data)).unwrap();
    }
    let study = dicom::scan(folder.path(), &ScanOptions::default()).map_err(|e| e.to_string())?;
    let index = study.default().map_err(|e| e.to_string())?;
    values(study.open(index, &OpenOptions::default()).map_err(|e| e.to_string())?)
}

fn plain() -> Vec<f64> {
    written(|_, data| file(EXPLICIT, &data)).unwrap()
}

/// The file of a data set with bytes put in front of `SliceThickness`.
fn with(mut data: Elements, bytes: &[u8]) -> Vec<u8> {
    let at = data.0.windows(4).position(|b| b == [0x18, 0, 0x50, 0]).unwrap();
    data.0.splice(at..at, bytes.iter().copied());
    file(EXPLICIT, &data)
}

/// A private element and its creator.
fn private(vr: [u8; 2], length: [u8; 4], value: &[u8]) -> Vec<u8> {
    let creator: &[u8] = b"\x11\0\x10\0LO\x04\0TEST";
    [creator, &[0x11, 0, 0x01, 0x10], &vr, &[0, 0], &length, value].concat()
}

#[test]
fn items_are_read_as_they_look_whatever_the_sequence_around_them_says() {
    let explicit: &[u8] = b"\x11\0\x10\0LO\x04\0TEST\x11\0\x02\x10LO\x04\0ABCD";
    let implicit: &[u8] = b"\x11\0\x10\0\x04\0\0\0TEST\x11\0\x02\x10\x04\0\0\0ABCD";
    let plain = plain();
    for vr in [*b"UN", *b"SQ"] {
        for content in [explicit, implicit] {
            let length = (content.len() as u32).to_le_bytes();
            let open = [&ITEM, &OPEN, content, &ITEM_END].concat();
            let closed = [&ITEM, &length, content].concat();
            for item in [open, closed] {
                let bytes = private(vr, OPEN, &[&*item, &SEQUENCE_END].concat());
                let read = written(|_, data| with(data, &bytes));
                assert_eq!(read.as_ref(), Ok(&plain), "{vr:?} {content:?}");
            }
        }
    }
}

#[test]
fn functional_groups_of_unknown_vr_may_have_explicit_items() {
    let read = |vr: [u8; 2]| {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("e.dcm");
        let mut bytes = file(EXPLICIT, &enhanced(&[(0, 0), (1, 1)], |_, _, _| {}));
        for tag in [[0x00, 0x52, 0x29, 0x92], [0x00, 0x52, 0x30, 0x92]] {
            let at = bytes.windows(4).position(|b| b == tag).unwrap();
            bytes[at + 4..at + 6].copy_from_slice(&vr);
        }
        std::fs::write(&path, bytes).unwrap();
        let study = dicom::scan(&path, &ScanOptions::default()).unwrap();
        values(study.open(0, &OpenOptions::default()).unwrap()).unwrap()
    };
    assert_eq!(read(*b"UN"), read(*b"SQ"));
}

#[test]
fn delimiters_too_many_end_nothing_and_one_left_out_is_seen_by_the_next() {
    let plain = plain();
    let element: &[u8] = b"\x11\0\x02\x10LO\x04\0ABCD";
    let length = (element.len() as u32).to_le_bytes();
    let left_out = [&ITEM, &OPEN, element, &SEQUENCE_END].concat();
    let too_many = [&ITEM, &length, element, &ITEM_END, &SEQUENCE_END].concat();
    let cases = [
        ITEM_END.to_vec(),
        SEQUENCE_END.to_vec(),
        [SEQUENCE_END, ITEM_END].concat(),
        private(*b"SQ", OPEN, &left_out),
        private(*b"SQ", OPEN, &too_many),
    ];
    for bytes in cases {
        let read = written(|_, data| with(data, &bytes));
        assert_eq!(read.as_ref(), Ok(&plain), "{bytes:X?}");
    }
}

#[test]
fn a_file_meta_group_in_implicit_vr_is_read() {
    let read = written(|_, data| {
        let mut meta = Elements::default();
        meta.text((0x0002, 0x0002), *b"UI", "1.2.840.10008.5.1.4.1.1.2");
        meta.text((0x0002, 0x0010), *b"UI", EXPLICIT);
        meta.make_implicit();
        [&[0; 128], b"DICM".as_slice(), &meta.0, &data.0].concat()
    });
    assert_eq!(read, Ok(plain()));
}

#[test]
fn a_big_endian_data_set_without_a_meta_group_is_seen_and_read() {
    let read = written(|_, mut data| {
        data.make_big();
        assert!(dicom::is_dicom(&data.0));
        data.0
    });
    assert_eq!(read, Ok(plain()));
}

#[test]
fn no_frames_are_one_frame() {
    let read = written(|_, mut data| {
        data.set((0x0028, 0x0008), *b"IS", b"0");
        file(EXPLICIT, &data)
    });
    assert_eq!(read, Ok(plain()));
}

#[test]
fn a_spacing_between_slices_that_is_no_number_says_nothing() {
    for spacing in ["unknown", "NaN", "inf"] {
        let read = written(|_, mut data| {
            data.set((0x0018, 0x0088), *b"DS", spacing.as_bytes());
            file(EXPLICIT, &data)
        });
        assert_eq!(read, Ok(plain()), "{spacing}");
    }
}

#[test]
fn padding_written_as_text_is_padding() {
    let padding = |vr: [u8; 2], value: &[u8]| {
        let folder = TempDir::new().unwrap();
        Series::axial(3).write_as(folder.path(), EXPLICIT, |_, data| {
            data.set((0x0028, 0x0103), *b"US", &1_u16.to_le_bytes());
            data.set((0x0028, 0x0120), vr, value);
        });
        let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
        let padding = study.open(0, &OpenOptions::default()).unwrap().meta.padding;
        padding.map(|p| (p.low, p.high))
    };
    assert_eq!(padding(*b"SS", &(-2000_i16).to_le_bytes()), Some((-2000.0, -2000.0)));
    for vr in [*b"IS", *b"DS", *b"LO"] {
        assert_eq!(padding(vr, b"-2000"), Some((-2000.0, -2000.0)), "{vr:?}");
        assert_eq!(padding(vr, b"63536 "), Some((-2000.0, -2000.0)), "{vr:?}");
    }
}
