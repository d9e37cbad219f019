//! The JPEG-LS decoder against `CharLS`, a frame at a time, and against damage.
//!
//! A folder of frames is what `testdata/jpegls/make.py` writes: NAME.jls, NAME.raw with what
//! `CharLS` decodes, and index.txt.

use mcubes::source::dicom::jpegls::decode;
use mcubes::source::dicom::{CodestreamError, DecodedFrame};

use crate::support::codestreams::{Frame, Process};
use crate::support::random::Random;

const PROCESS: Process = Process { decode, folder: "testdata/jpegls", extension: "jls" };

#[test]
fn the_kept_frames_decode_to_what_charls_makes_of_them() {
    PROCESS.check_kept(15);
}

#[test]
#[ignore = "needs a folder that testdata/jpegls/make.py --many has filled, in JPEGLS_FRAMES"]
fn many_frames_decode_to_what_charls_makes_of_them() {
    PROCESS.check_folder("JPEGLS_FRAMES");
}

#[test]
fn a_frame_cut_anywhere_is_an_error_unless_only_its_end_marker_is_gone() {
    for frame in PROCESS.kept() {
        let Frame { name, rows, cols, stream, samples, .. } = &frame;
        for cut in 0..stream.len() {
            match decode(&stream[..cut], *rows, *cols) {
                Ok(decoded) => assert_eq!(&decoded.samples, samples, "{name}: cut at {cut}"),
                Err(error) => assert!(!error.to_string().contains('\n'), "{name}: {error:?}"),
            }
        }
        // The last byte may hold nothing but what fills it.
        let data = frame.data_begin();
        assert!(decode(&stream[..data], *rows, *cols).is_err(), "{name}");
        let half = data + (stream.len() - 2 - data) / 2;
        if half + 4 < stream.len() && !name.contains("1x1") {
            assert!(decode(&stream[..half], *rows, *cols).is_err(), "{name}");
        }
    }
}

#[test]
fn no_damage_makes_the_decoder_panic_or_give_samples_beyond_its_bits() {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    PROCESS.check_damage(&mut random);
}

#[test]
fn random_data_behind_a_good_header_never_panic() {
    let mut random = Random::new(0x2545_F491_4F6C_DD1D);
    for frame in PROCESS.kept() {
        let mut stream = frame.stream[..frame.data_begin()].to_vec();
        // All bytes below 80, so that no marker ends the data early.
        stream.extend((0..20_000).map(|_| random.below(0x80) as u8));
        _ = decode(&stream, frame.rows, frame.cols);
        for fill in [0x00, 0x7F, 0x55] {
            stream.truncate(frame.data_begin());
            stream.resize(20_000, fill);
            _ = decode(&stream, frame.rows, frame.cols);
        }
    }
}

#[test]
fn padding_after_the_frame_and_a_missing_end_marker_change_nothing() {
    for frame in PROCESS.kept() {
        let Frame { name, rows, cols, bits, stream, samples } = frame;
        let wanted = DecodedFrame { bits, samples };
        for padding in [&[0][..], &[0, 0], &[0xFF], b"\0odd"] {
            let padded = [&stream[..], padding].concat();
            assert_eq!(decode(&padded, rows, cols).as_ref(), Ok(&wanted), "{name}");
        }
        let endless = &stream[..stream.len() - 2];
        assert_eq!(decode(endless, rows, cols).as_ref(), Ok(&wanted), "{name}");
        // Zeros are padding behind coded data only, not behind a segment or fill bytes.
        if name == "lines-follow-12" || name == "restart-12-wide" {
            continue;
        }
        let zeros = [endless, &[0, 0, 0]].concat();
        assert_eq!(decode(&zeros, rows, cols).as_ref(), Ok(&wanted), "{name}");
    }
}

#[test]
fn data_that_no_row_asks_for_are_an_error() {
    let Frame { rows, cols, stream, .. } = PROCESS.kept_frame("charls-12-bell");
    let longer = [&stream[..stream.len() - 2], &[0x12, 0x34, 0x56], &[0xFF, 0xD9]].concat();
    let error = decode(&longer, rows, cols).unwrap_err();
    assert!(matches!(error, CodestreamError::LeftOver { row: 24, rows: 24, .. }), "{error:?}");
}

#[test]
fn a_frame_of_another_size_is_refused_with_both_sizes() {
    let Frame { rows, cols, stream, .. } = PROCESS.kept_frame("charls-12-bell");
    for (rows, cols) in [(rows + 1, cols), (rows, cols - 1), (cols, rows), (0, 0), (usize::MAX, 2)]
    {
        let error = decode(&stream, rows, cols).unwrap_err();
        let wanted = CodestreamError::SizeMismatch { found_rows: 24, found_cols: 40, rows, cols };
        assert_eq!(error, wanted);
    }
    let follow = PROCESS.kept_frame("lines-follow-12");
    let error = decode(&follow.stream, usize::MAX, follow.cols).unwrap_err();
    assert!(matches!(error, CodestreamError::Field { field: "Rows", .. }), "{error:?}");
}

#[test]
fn what_is_not_decoded_is_refused_by_name() {
    let frame = PROCESS.kept_frame("preset-12");
    let (rows, cols) = (frame.rows, frame.cols);
    let refusal = |stream: &[u8]| decode(stream, rows, cols).unwrap_err().to_string();
    let cases = [
        (frame.changed(0xF7, 9, 3), "a number of components but 1 (3)"),
        (frame.changed(0xF8, 4, 2), "a mapping table, LSE of type (2)"),
        (frame.changed(0xF8, 4, 4), "an oversize image, LSE of type (4)"),
        (frame.changed(0xDA, 6, 1), "a mapping table (1)"),
        (frame.changed(0xDA, 9, 1), "a point transform (1)"),
        (frame.changed(0xF7, 1, 0xC3), "marker FFC3 (lossless JPEG)"),
    ];
    for (stream, wanted) in cases {
        let found = refusal(&stream);
        assert!(found.contains(wanted), "{found}");
    }
    assert!(refusal(b"RIFF").contains("5249"));
}

#[test]
fn parameters_outside_the_standard_are_refused_with_their_values() {
    let frame = PROCESS.kept_frame("preset-12");
    let (rows, cols) = (frame.rows, frame.cols);
    let cases = [
        (frame.changed(0xF7, 4, 17), "P is 17, expected 2 to 16"),
        (frame.changed(0xF7, 4, 1), "P is 1, expected 2 to 16"),
        (frame.changed(0xF8, 5, 0x10), "MAXVAL is 4280, expected 1 to 4095"),
        (frame.changed(0xF8, 7, 0x01), "T2 is 40, expected 265 to 3000"),
        (frame.changed(0xF8, 14, 2), "RESET is 2, expected 3 to 3000"),
        (frame.changed(0xDA, 7, 20), "T1 is 9, expected 21 to 3000"),
        (frame.changed(0xDA, 8, 3), "ILV is 3, expected 0 to 2"),
    ];
    for (stream, wanted) in cases {
        assert_eq!(decode(&stream, rows, cols).unwrap_err().to_string(), wanted);
    }
    let eight = PROCESS.kept_frame("charls-2-low");
    let error = decode(&eight.changed(0xDA, 7, 2), eight.rows, eight.cols).unwrap_err();
    assert_eq!(error.to_string(), "NEAR is 2, expected 0 to 1");
}

#[test]
fn a_wrong_restart_marker_is_named_with_the_one_that_was_due() {
    let Frame { rows, cols, mut stream, .. } = PROCESS.kept_frame("restart-12");
    let second = stream.windows(2).position(|w| w == [0xFF, 0xD1]).unwrap();
    stream[second + 1] = 0xD3;
    let wanted = CodestreamError::Restart { row: 4, found: 0xFFD3, expected: 0xFFD1 };
    assert_eq!(decode(&stream, rows, cols), Err(wanted));
}
