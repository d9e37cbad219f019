//! The lossless JPEG decoder against `SimpleITK`, a frame at a time, against damage, and in files.
//!
//! A folder of frames is what `testdata/ljpeg/make.py` writes.

use mcubes::error::Failure;
use mcubes::source::dicom::ljpeg::decode;
use mcubes::source::dicom::{self, CodestreamError, DecodedFrame, OpenOptions, ScanOptions};
use mcubes::{Error, Kind};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::codestreams::{Frame, Process};
use crate::support::dicom::{Elements, Series};
use crate::support::ljpeg::encode_bits;
use crate::support::random::Random;

const SV1: &str = "1.2.840.10008.1.2.4.70";

const PROCESS: Process = Process { decode, folder: "testdata/ljpeg", extension: "ljpeg" };

#[test]
fn the_kept_frames_decode_to_what_simpleitk_makes_of_them() {
    PROCESS.check_kept(20);
}

#[test]
#[ignore = "needs a folder that testdata/ljpeg/make.py --many has filled, in LJPEG_FRAMES"]
fn many_frames_decode_to_what_simpleitk_makes_of_them() {
    PROCESS.check_folder("LJPEG_FRAMES");
}

#[test]
fn a_frame_cut_anywhere_is_an_error_unless_only_its_end_marker_is_gone() {
    for frame in PROCESS.kept() {
        let Frame { name, rows, cols, stream, samples, .. } = &frame;
        for cut in 0..stream.len() {
            let with_end = [&stream[..cut], &[0xFF, 0xD9]].concat();
            for cut in [&stream[..cut], &with_end] {
                match decode(cut, *rows, *cols) {
                    Ok(decoded) => {
                        assert_eq!(&decoded.samples, samples, "{name}: {} bytes", cut.len());
                    }
                    Err(error) => assert!(!error.to_string().contains('\n'), "{name}: {error:?}"),
                }
            }
        }
    }
}

#[test]
fn data_that_end_early_say_in_which_row() {
    let frame = PROCESS.kept_frame("first-12");
    let half = &frame.stream[..frame.stream.len() / 2];
    let error = decode(half, frame.rows, frame.cols).unwrap_err();
    assert_eq!(error.kind(), Kind::TruncatedData);
    assert!(error.to_string().contains("of 24, after"), "{error}");
    let error = decode(&[half, &[0xFF, 0xD9]].concat(), frame.rows, frame.cols).unwrap_err();
    assert!(matches!(error, CodestreamError::EarlyMarker { marker: 0xFFD9, .. }), "{error:?}");
}

#[test]
fn no_damage_makes_the_decoder_panic_or_give_samples_beyond_its_bits() {
    let mut random = Random::new(14);
    PROCESS.check_damage(&mut random);
    for frame in PROCESS.kept() {
        let mut stream = frame.stream[..frame.data_begin()].to_vec();
        stream.extend((0..20_000).map(|_| random.below(0xFF) as u8));
        _ = decode(&stream, frame.rows, frame.cols);
    }
}

#[test]
fn padding_after_the_frame_and_a_missing_end_marker_change_nothing() {
    for Frame { name, rows, cols, bits, stream, samples } in PROCESS.kept() {
        let wanted = DecodedFrame { bits, samples };
        for padding in [&[0][..], &[0, 0], &[0xFF], b"\0odd"] {
            let padded = [&stream[..], padding].concat();
            assert_eq!(decode(&padded, rows, cols).as_ref(), Ok(&wanted), "{name}");
        }
        let endless = &stream[..stream.len() - 2];
        for end in [&[][..], &[0], &[0, 0, 0], &[0xFF, 0xFF, 0xFF, 0xD9]] {
            let padded = [endless, end].concat();
            assert_eq!(decode(&padded, rows, cols).as_ref(), Ok(&wanted), "{name}");
        }
    }
}

#[test]
fn data_that_no_row_asks_for_are_an_error() {
    let Frame { rows, cols, stream, .. } = PROCESS.kept_frame("first-12");
    let longer = [&stream[..stream.len() - 2], &[0x12, 0x34, 0x56], &[0xFF, 0xD9]].concat();
    let error = decode(&longer, rows, cols).unwrap_err();
    assert!(matches!(error, CodestreamError::LeftOver { row: 24, rows: 24, .. }), "{error:?}");
}

#[test]
fn what_is_not_decoded_is_refused_by_name() {
    let frame = PROCESS.kept_frame("restart-1");
    let cases = [
        (frame.changed(0xC3, 9, 3), "the frame has 3 components, expected 1"),
        (frame.changed(0xC3, 1, 0xC0), "marker FFC0 (baseline JPEG), expected FFC3"),
        (frame.changed(0xC3, 6, 0), "a number of lines that follows the samples (DNL), Y (0)"),
        (frame.changed(0xC3, 6, 21), "the frame is 33 x 21, expected 33 x 20"),
        (frame.changed(0xC3, 4, 17), "P is 17, expected 2 to 16"),
        (frame.changed(0xDA, 7, 0), "Ss is 0, expected 1 to 7"),
        (frame.changed(0xDA, 9, 12), "Pt is 12, expected 0 to 11"),
        (frame.changed(0xDA, 6, 0x10), "the Huffman table 1 is not in the stream"),
        (frame.changed(0xDD, 5, 34), "every 34 samples are not at the ends of rows of 33"),
        (frame.changed(0xD1, 1, 0xD3), "found FFD3 after row 2, expected restart marker FFD1"),
    ];
    for (stream, wanted) in cases {
        let found = decode(&stream, frame.rows, frame.cols).unwrap_err().to_string();
        assert!(found.contains(wanted), "{found}, not {wanted}");
    }
    let second = [&frame.stream[..frame.stream.len() - 2], &[0xFF, 0xDA, 0, 2]].concat();
    let found = decode(&second, frame.rows, frame.cols).unwrap_err();
    assert!(found.to_string().contains("a second scan"), "{found}");
}

#[test]
fn a_sample_beyond_its_bits_is_damage_unless_the_sign_fills_them() {
    let signed = encode_bits(&[0xFFF0, 5, 0xF800, 0x7FF], 2, 12);
    assert_eq!(decode(&signed, 2, 2).unwrap().samples, [0xFF0, 5, 0x800, 0x7FF]);
    let damaged = encode_bits(&[1, 2, 0x1001, 3], 2, 12);
    let wanted = CodestreamError::Sample { row: 2, rows: 2, found: 0x1001, most: 0xFFF };
    assert_eq!(decode(&damaged, 2, 2), Err(wanted));
}

const ALLOCATED: (u16, u16) = (0x0028, 0x0100);

/// What a series of three slices gives whose samples are `samples`, coded in `bits` bits.
fn in_files(samples: &[u16; 4], bits: u8, allocated: u16, stored: u16, sign: u16) -> Vec<f64> {
    let series = Series { cols: 2, rows: 2, ..Series::axial(3) };
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), SV1, |_, data: &mut Elements| {
        for (n, value) in (0..).zip([allocated, stored, stored - 1, sign]) {
            data.set((ALLOCATED.0, ALLOCATED.1 + n), *b"US", &value.to_le_bytes());
        }
        data.remove((0x0028, 0x1052));
        data.remove((0x0028, 0x1053));
        data.set_image(&encode_bits(samples, 2, bits));
    });
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    values(volume).unwrap()[..4].to_vec()
}

#[test]
fn the_sign_of_signed_samples_is_where_simpleitk_takes_it() {
    let of = |bits: u8, stored: u16| {
        let top = u16::MAX >> (16 - bits);
        in_files(&[0, 1, top / 2 + 1, top], bits, 16, stored, 1)
    };
    // In 9 to 11 bits all samples of 12 or 16 are positive.
    for (bits, stored) in [(9, 16), (10, 16), (11, 16), (9, 12), (10, 12), (11, 12), (9, 10)] {
        let half = f64::from(1_u32 << (bits - 1));
        assert_eq!(of(bits, stored), [0.0, 1.0, half, half * 2.0 - 1.0], "{bits} of {stored}");
    }
    // Samples of 8, 12 or more bits have their own.
    for (bits, stored) in [(8, 16), (8, 12), (12, 16), (13, 16), (15, 16), (16, 16), (10, 10)] {
        let half = f64::from(1_u32 << (bits - 1));
        assert_eq!(of(bits, stored), [0.0, 1.0, -half, -1.0], "{bits} of {stored}");
    }
    // Bits beyond those stored are none.
    assert_eq!(of(13, 12), [0.0, 1.0, 0.0, -1.0]);
}

#[test]
fn fewer_than_eight_bits_are_read_in_samples_of_a_byte_and_of_two() {
    for (allocated, stored) in [(8, 7), (8, 8), (16, 7), (16, 16)] {
        let found = in_files(&[0, 1, 64, 127], 7, allocated, stored, 0);
        assert_eq!(found, [0.0, 1.0, 64.0, 127.0], "{allocated} {stored}");
    }
}

#[test]
fn a_frame_that_ends_early_is_no_slice_of_zeros() {
    let series = Series::axial(5);
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), SV1, |k, data| {
        let samples: Vec<u16> = (0..series.cols * series.rows).collect();
        let mut image = encode_bits(&samples, series.cols, 16);
        if k == 3 {
            image.truncate(image.len() / 2);
            image.extend([0xFF, 0xD9]);
        }
        data.set_image(&image);
    });
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    let error = mcubes::source::survey(volume, &mcubes::cancel::Cancel::new()).unwrap_err();
    let error = Error::at(folder.path(), error);
    assert_eq!(error.kind(), Kind::CorruptPixels, "{error}");
    assert!(error.to_string().contains("marker FFD9"), "{error}");
    assert!(error.hint().unwrap().contains("damaged"), "{error}");
}
