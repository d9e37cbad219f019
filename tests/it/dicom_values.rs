//! The values of a DICOM series are the same however its files write them.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use mcubes::volume::Meta;
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{EXPLICIT, Elements, PIXELS, Series};
use crate::support::ljpeg;

const JPEG_LOSSLESS: &str = "1.2.840.10008.1.2.4.70";

const BITS_STORED: (u16, u16) = (0x0028, 0x0101);
const HIGH_BIT: (u16, u16) = (0x0028, 0x0102);
const SIGN: (u16, u16) = (0x0028, 0x0103);

/// The facts and the real values of the one volume in a folder.
fn read(folder: &Path) -> (Meta, Vec<f64>) {
    let study = dicom::scan(folder, &ScanOptions::default()).unwrap();
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    (volume.meta.clone(), values(volume).unwrap())
}

/// What a series gives that is written in a syntax, with its elements changed.
fn written(series: &Series, syntax: &str, change: impl Fn(usize, &mut Elements)) -> Vec<f64> {
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), syntax, change);
    read(folder.path()).1
}

/// The series, whose stored values take 13 bits, and its real values.
fn series() -> (Series, Vec<f64>) {
    let series = Series::axial(5);
    let plain = written(&series, EXPLICIT, |_, _| {});
    (series, plain)
}

fn words(data: &Elements) -> Vec<u16> {
    data.value(PIXELS).chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()
}

fn set_bits(data: &mut Elements, stored: u16, high: u16, sign: u16) {
    for (tag, value) in [(BITS_STORED, stored), (HIGH_BIT, high), (SIGN, sign)] {
        data.set(tag, *b"US", &value.to_le_bytes());
    }
}

#[test]
fn bits_above_bits_stored_are_no_part_of_a_compressed_value() {
    let (series, plain) = series();
    let found = written(&series, JPEG_LOSSLESS, |_, data| {
        let cells: Vec<u16> = words(data).iter().map(|w| w | 0x6000).collect();
        data.set_image(&ljpeg::encode(&cells, series.cols));
        set_bits(data, 13, 12, 0);
    });
    assert_eq!(found, plain);
}

#[test]
fn a_signed_compressed_value_has_its_sign_in_the_highest_of_bits_stored() {
    let (series, plain) = series();
    for upper_bits in [0, 0xE000] {
        let found = written(&series, JPEG_LOSSLESS, |_, data| {
            let signed = words(data).into_iter().map(|w| w.wrapping_sub(2200));
            // Zeros, or the sign again, in the bits that are not used.
            let cells: Vec<u16> =
                signed.map(|w| w & 0x1FFF | if w >> 15 == 1 { upper_bits } else { 0 }).collect();
            data.set_image(&ljpeg::encode(&cells, series.cols));
            set_bits(data, 13, 12, 1);
        });
        let wanted: Vec<f64> = plain.iter().map(|v| v - 2200.0 * 0.25).collect();
        assert_eq!(found, wanted, "{upper_bits:x}");
    }
}

#[test]
fn compressed_cells_have_their_value_below_high_bit() {
    let (series, plain) = series();
    let found = written(&series, JPEG_LOSSLESS, |_, data| {
        let cells: Vec<u16> = words(data).iter().map(|w| w << 2 | 0x8001).collect();
        data.set_image(&ljpeg::encode(&cells, series.cols));
        set_bits(data, 13, 14, 0);
    });
    assert_eq!(found, plain);
}
