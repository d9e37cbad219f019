//! Any bytes as a NIfTI file: looked at, opened, and the last of its volumes read.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::cancel::Cancel;
use mcubes::source::{OpenOptions, open, sniff, volumes};

fuzz_target!(|bytes: &[u8]| {
    mcubes_fuzz::with_file(bytes, |path| {
        let _ = sniff(path);
        let last = volumes(path).map(|all| all.len()).unwrap_or(1);
        mcubes_fuzz::read_all(open(path, &OpenOptions { volume: Some(last) }, &Cancel::new()));
    });
});
