//! Any bytes as raw samples: the first few say which dimensions, type and offset are claimed.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::cancel::Cancel;
use mcubes::source::{RawInput, RawOptions, open_raw};
use mcubes::volume::StoredType;

fuzz_target!(|bytes: &[u8]| {
    let Some((&[x, y, z, kind, offset, odd], rest)) = bytes.split_first_chunk::<6>() else {
        return;
    };
    let stored = StoredType::ALL[usize::from(kind) % StoredType::ALL.len()];
    // Mostly small, now and then beyond all bounds.
    let dim = |n: u8| if n == 255 { i64::MAX } else { i64::from(n) - 1 };
    let mut options = RawOptions::new([dim(x), dim(y), dim(z)], stored);
    options.big_endian = odd & 1 == 1;
    options.offset_bytes = if offset == 255 { u64::MAX } else { u64::from(offset) };
    options.spacing_mm[2] = f64::from(odd >> 1);
    mcubes_fuzz::with_file(rest, |path| {
        mcubes_fuzz::read_all(open_raw(RawInput::Path(path.to_owned()), &options, &Cancel::new()));
    });
});
