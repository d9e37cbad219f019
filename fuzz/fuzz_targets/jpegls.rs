//! Any bytes as a JPEG-LS frame: the first two are its rows and columns.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::source::dicom::jpegls::decode;
use mcubes_fuzz::decode_frame;

fuzz_target!(|bytes: &[u8]| decode_frame(bytes, decode));
