//! Any bytes as a DICOM file or a zip of them: scanned, and every volume read.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::Kind;
use mcubes::source::dicom::{OpenOptions, ScanOptions, scan};

fuzz_target!(|bytes: &[u8]| {
    mcubes_fuzz::with_file(bytes, |path| match scan(path, &ScanOptions::default()) {
        Ok(study) => {
            let _ = study.default();
            for index in 0..study.volumes.len().min(8) {
                let _ = (study.choice(index), study.slices(index));
                mcubes_fuzz::read_all(study.open(index, &OpenOptions { span_gaps: true }));
            }
        }
        Err(error) => assert_ne!(error.kind(), Kind::Internal),
    });
});
