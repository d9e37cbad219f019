//! DICOM of a few bytes that asks for much memory or much of the disk: refused before it has it.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::io::Write;
use std::path::{Path, PathBuf};

use mcubes::Error;
use mcubes::error::Kind;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use tempfile::TempDir;
use zip::write::SimpleFileOptions;

use crate::dicom::values;
use crate::support::dicom::{EXPLICIT, Elements, PIXELS, Series, file};
#[cfg(target_os = "linux")]
use crate::support::memory::{assert_peak_below, is_alone};
use crate::support::repository;
use crate::support::sandbox::{Sandbox, stderr};

const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
const RLE: &str = "1.2.840.10008.1.2.5";
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

#[cfg(target_os = "linux")]
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
    let error = read(&path).unwrap_err();
    assert_eq!(error.kind(), Kind::TooLarge, "{error}");
    assert_peak_below(600);
}

/// Scans, opens and reads all.
fn read(path: &Path) -> Result<Vec<f64>, Error> {
    let study = dicom::scan(path, &ScanOptions::default())?;
    let volume = study.open(study.default()?, &OpenOptions::default())?;
    let found = mcubes::source::survey(volume, &mcubes::cancel::Cancel::new())
        .map_err(|e| Error::at(path, e));
    found.map(|_| ())?;
    let volume = study.open(study.default()?, &OpenOptions::default())?;
    Ok(values(volume).unwrap())
}

/// Frames of one sample row that repeats: the RLE image of a slice of `series`, all of one value.
fn rle(series: &Series) -> Vec<u8> {
    let mut image = vec![0; 64];
    let mut segment = Vec::new();
    let mut left = usize::from(series.rows) * usize::from(series.cols);
    while left > 1 {
        let run = left.min(128);
        segment.extend([(257 - run) as u8, 7]);
        left -= run;
    }
    segment.resize(segment.len().next_multiple_of(2), 128);
    image[0] = 2;
    image[4] = 64;
    image[8..12].copy_from_slice(&(64 + segment.len() as u32).to_le_bytes());
    [image, segment.clone(), segment].concat()
}

fn deflate() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated)
}

/// An archive with three RLE slices, each followed by so many zeros.
fn archive(folder: &Path, zeros: usize, change: impl Fn(&mut Elements)) -> PathBuf {
    let path = folder.join("study.zip");
    let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let series = Series::axial(3);
    let slices = folder.join("slices");
    series.write_as(&slices, RLE, |_, data| {
        data.set_image(&rle(&series));
        change(data);
    });
    for entry in std::fs::read_dir(&slices).unwrap() {
        let slice = entry.unwrap();
        archive.start_file(slice.file_name().to_str().unwrap(), deflate()).unwrap();
        archive.write_all(&std::fs::read(slice.path()).unwrap()).unwrap();
        for _ in 0..zeros >> 20 {
            archive.write_all(&vec![0; 1 << 20]).unwrap();
        }
    }
    archive.finish().unwrap();
    path
}

#[cfg(target_os = "linux")]
#[test]
fn what_follows_the_pixels_in_a_zip_entry_takes_no_memory() {
    if !is_alone("dicom_memory::what_follows_the_pixels_in_a_zip_entry_takes_no_memory") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let values = read(&archive(folder.path(), 256 << 20, |_| {})).unwrap();
    assert!(values.iter().all(|v| *v == values[0]) && values.len() == 3 * 40 * 36);
    assert_peak_below(128);
}

#[test]
fn a_fragment_much_larger_than_the_image_it_holds_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = archive(folder.path(), 32 << 20, |data| {
        // The one fragment reaches to the end of the entry.
        let at = data.0.len() - 8;
        data.0.truncate(at);
        let image = rle(&Series::axial(3)).len();
        let length = (image + (32 << 20)) as u32;
        data.0[at - image - 4..at - image].copy_from_slice(&length.to_le_bytes());
    });
    let error = read(&path).unwrap_err();
    assert_eq!(error.kind(), Kind::TooLarge, "{error}");
    assert!(error.to_string().contains("the compressed pixels need more than"), "{error}");
}

/// An archive with one compressed file of several frames, followed by so many zeros.
fn archived_frames(folder: &Path, zeros: usize) -> PathBuf {
    let path = folder.join("frames.zip");
    let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let frames = repository("testdata/dicom/enhanced-ct-shuffled.dcm");
    archive.start_file("frames", deflate()).unwrap();
    archive.write_all(&std::fs::read(frames).unwrap()).unwrap();
    archive.write_all(&vec![0; zeros]).unwrap();
    archive.finish().unwrap();
    path
}

#[test]
fn frames_in_an_archive_are_not_unpacked_beyond_what_they_need() {
    let folder = TempDir::new().unwrap();
    assert!(read(&archived_frames(folder.path(), 1 << 10)).is_ok());
    let error = read(&archived_frames(folder.path(), 32 << 20)).unwrap_err();
    assert_eq!(error.kind(), Kind::TooLarge, "{error}");
}

#[test]
fn a_zip_entry_that_gives_more_than_its_size_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = archive(folder.path(), 0, |_| {});
    read(&path).unwrap();
    let slice = std::fs::read_dir(folder.path().join("slices")).unwrap().next().unwrap().unwrap();
    let size = slice.metadata().unwrap().len() as u32;
    // The size without the delimiter after the pixels, which need not be there.
    let mut bytes = std::fs::read(&path).unwrap();
    let places = (0..bytes.len() - 4).filter(|&at| bytes[at..at + 4] == size.to_le_bytes());
    for at in places.collect::<Vec<_>>() {
        bytes[at..at + 4].copy_from_slice(&(size - 8).to_le_bytes());
    }
    std::fs::write(&path, bytes).unwrap();
    let error = read(&path).unwrap_err();
    assert_eq!(error.kind(), Kind::CorruptCompression, "{error}");
    assert!(error.to_string().contains("larger than its declared"), "{error}");
}

#[test]
fn a_run_that_is_stopped_unpacks_no_frames() {
    let folder = TempDir::new().unwrap();
    let options = ScanOptions::default();
    let study = dicom::scan(&archived_frames(folder.path(), 0), &options).unwrap();
    let index = study.default().unwrap();
    options.cancel.raise();
    let error = study.open(index, &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::Interrupted, "{error}");
}
