//! Any bytes as a lossless JPEG frame: the first two are its rows and columns.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::source::dicom::ljpeg::decode;

fuzz_target!(|bytes: &[u8]| {
    let [rows, cols, stream @ ..] = bytes else { return };
    let (rows, cols) = (usize::from(*rows), usize::from(*cols));
    if let Ok(decoded) = decode(stream, rows, cols) {
        assert_eq!(decoded.samples.len(), rows * cols);
        let largest = u16::MAX >> (16 - decoded.bits);
        assert!(decoded.samples.iter().all(|&sample| sample <= largest));
    }
});
