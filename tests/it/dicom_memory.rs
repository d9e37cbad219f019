//! DICOM of a few bytes that asks for much memory or much of the disk: refused before it has it.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::io::Write;

use mcubes::error::Kind;
use mcubes::source::dicom::{self, ScanOptions};
use tempfile::TempDir;

use crate::support::dicom::{EXPLICIT, Elements, PIXELS, file};
use crate::support::memory::{assert_peak_below, is_alone};
use crate::support::sandbox::{Sandbox, stderr};

const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
const FRAMES: (u16, u16) = (0x0028, 0x0008);

/// A data set of so many frames of one sample; its pixels claim `length` bytes and have as many as
/// are given.
fn tiny_frames(n_frames: u32, bits: u16, length: u32, pixels: &[u8]) -> Elements {
    let mut data = Elements::default();
    data.text((0x0008, 0x0016), *b"UI", "1.2.840.10008.5.1.4.1.1.2");
    // A long text that each frame has a copy of.
    data.text((0x0008, 0x0008), *b"CS", &"ORIGINAL\\".repeat(4000));
    data.text((0x0020, 0x000E), *b"UI", "1.2.3");
    data.short((0x0028, 0x0002), 1);
    data.text((0x0028, 0x0004), *b"CS", "MONOCHROME2");
    data.text(FRAMES, *b"IS", &n_frames.to_string());
    data.short((0x0028, 0x0010), 1);
    data.short((0x0028, 0x0011), 1);
    data.short((0x0028, 0x0100), bits);
    data.short((0x0028, 0x0101), bits);
    data.short((0x0028, 0x0102), bits - 1);
    data.short((0x0028, 0x0103), 0);
    data.element(PIXELS, *b"OB", &[]);
    let end = data.0.len();
    data.0[end - 4..].copy_from_slice(&length.to_le_bytes());
    data.0.extend(pixels);
    data
}

/// What the command says of a file that it refuses.
fn refused(name: &str, bytes: &[u8]) -> String {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.path(name), bytes).unwrap();
    let output = sandbox.run(&["info", name]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{said}");
    said
}

#[test]
fn frames_that_a_deflated_file_only_claims_are_refused() {
    let data = tiny_frames(i32::MAX as u32, 8, 0xFFFF_FFFE, &[0; 16]);
    let whole = file(DEFLATED, &Elements::default());
    let mut deflate = flate2::write::DeflateEncoder::new(whole, flate2::Compression::best());
    deflate.write_all(&data.0).unwrap();
    let bytes = deflate.finish().unwrap();
    assert!(bytes.len() < 1 << 10, "{}", bytes.len());
    let said = refused("claims", &bytes);
    assert!(said.contains("2147483647 frames"), "{said}");
}

#[test]
fn frames_of_one_bit_each_are_refused_where_listing_them_takes_too_much() {
    let n_frames = 4_000_000;
    let pixels = vec![0; n_frames as usize / 8];
    let data = tiny_frames(n_frames, 1, n_frames / 8, &pixels);
    let said = refused("bits", &file(EXPLICIT, &data));
    assert!(said.contains("4000000 frames"), "{said}");
}

#[test]
fn frames_are_refused_for_the_text_that_each_would_hold() {
    let test = "dicom_memory::frames_are_refused_for_the_text_that_each_would_hold";
    if !is_alone(test) {
        return;
    }
    let n_frames = 100_000;
    let data = tiny_frames(n_frames, 8, n_frames, &vec![0; n_frames as usize]);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("text");
    std::fs::write(&path, file(EXPLICIT, &data)).unwrap();
    let error = dicom::scan(&path, &ScanOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::TooLarge, "{error}");
    assert_peak_below(600);
}
