//! DICOM that is damaged: one clear error or a warning that names the file, never a panic, never
//! a mesh of data that are not there.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::path::{Path, PathBuf};

use mcubes::Error;
use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{EXPLICIT, Elements, Series, file};
#[cfg(target_os = "linux")]
use crate::support::memory::{assert_peak_below, is_alone};
use crate::support::repository;

/// Scans, opens and reads all; the notes if that goes well.
fn read(path: &Path) -> Result<Vec<String>, Error> {
    let study = dicom::scan(path, &ScanOptions::default())?;
    let index = study.default()?;
    let volume = study.open(index, &OpenOptions::default())?;
    let notes = volume.meta.notes.iter().map(ToString::to_string).collect();
    values(volume).map_err(|e| {
        let other = mcubes::source::SourceError::Other {
            kind: mcubes::error::Kind::CorruptPixels,
            message: e,
            hint: None,
        };
        Error::at(path, other)
    })?;
    Ok(notes)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    files
}

#[test]
fn a_damaged_slice_within_a_series_is_named() {
    let folder = repository("testdata/dicom-bad");
    for bad in files(&folder) {
        let copy = TempDir::new().unwrap();
        for good in files(&folder.join("good-series")) {
            std::fs::copy(&good, copy.path().join(good.file_name().unwrap())).unwrap();
        }
        std::fs::copy(&bad, copy.path().join("IM2.dcm")).unwrap();
        let said = match read(copy.path()) {
            Err(e) => e.to_string(),
            Ok(notes) => notes.join(" "),
        };
        let name = bad.file_name().unwrap().to_string_lossy().into_owned();
        eprintln!("{name}: {said}");
        // What is no DICOM at all leaves a gap and no more to say; one item is in order once its
        // missing delimiter is forgiven.
        let silent =
            ["empty.dcm", "text.dcm", "no-pixel-data.dcm", "no-delimiter-encapsulated.dcm"];
        if silent.contains(&name.as_str()) {
            let fine = said.is_empty() || said.contains("between IM1.dcm and IM3.dcm");
            assert!(fine || said.contains("set aside"), "{name}: {said}");
        } else {
            assert!(said.contains("IM2.dcm"), "{name}: {said}");
        }
    }
}

#[test]
fn every_refusal_is_one_line_in_lower_case() {
    let folder = repository("testdata/dicom-bad");
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let Err(error) = read(&path) else { continue };
        let line = error.to_string().replace(&*path.to_string_lossy(), "PATH");
        assert!(line.starts_with("PATH: "), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
        assert!(!line.ends_with('.') && line.len() < 400, "{line}");
        for word in ["panicked", "unwrap", "Err(", "Some(", "{ "] {
            assert!(!line.contains(word), "{line}");
        }
    }
}

#[test]
fn a_cut_file_gives_an_error_at_whatever_byte_it_is_cut() {
    let whole = Series::axial(3).image(1, 1);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("cut");
    let header = whole.len() - 2 * 40 * 36;
    let cuts = (0..header).chain((header..whole.len()).step_by(97));
    for cut in cuts {
        std::fs::write(&path, &whole[..cut]).unwrap();
        assert!(read(&path).is_err(), "cut at {cut}");
    }
}

/// Small numbers in a row that look random, the same each time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }
}

/// Reads every file of `testdata`, and one made here, with a few bytes changed, again and again.
fn flip_bytes() {
    let folder = TempDir::new().unwrap();
    let mut dice = Dice(20);
    let own = Series::axial(4);
    let mut seeds: Vec<Vec<u8>> = vec![own.image(1, 1)];
    let copies = repository("testdata/dicom");
    for entry in std::fs::read_dir(&copies).unwrap() {
        let path = entry.unwrap().path();
        let first = if path.is_dir() { files(&path).swap_remove(0) } else { path };
        seeds.push(std::fs::read(first).unwrap());
    }
    for (s, seed) in seeds.iter().enumerate() {
        // The other slices, so that the damaged one takes part in a volume.
        let series = folder.path().join(s.to_string());
        own.write(&series);
        let damaged = series.join("damaged");
        for _ in 0..120 {
            let mut bytes = seed.clone();
            for _ in 0..=dice.below(6) {
                let header = bytes.len().min(2048);
                let at =
                    if dice.below(3) == 0 { dice.below(bytes.len()) } else { dice.below(header) };
                bytes[at] = match dice.below(4) {
                    0 => 0,
                    1 => 0xFF,
                    2 => bytes[at] ^ (1 << dice.below(8)),
                    _ => dice.below(256) as u8,
                };
            }
            std::fs::write(&damaged, &bytes).unwrap();
            let _ = read(&damaged);
            let _ = read(&series);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn flipped_bytes_never_panic_nor_take_much_memory() {
    if is_alone("dicom_hostile::flipped_bytes_never_panic_nor_take_much_memory") {
        flip_bytes();
        assert_peak_below(512);
    }
}

#[cfg(not(target_os = "linux"))]
#[test]
fn flipped_bytes_never_panic() {
    flip_bytes();
}

#[test]
fn sequences_within_sequences_without_end_are_refused() {
    let mut data = Elements::default();
    for _ in 0..20_000 {
        // A sequence and an item, both of undefined length.
        data.0.extend([0x08, 0, 0x40, 0x11, b'S', b'Q', 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]);
        data.0.extend([0xFE, 0xFF, 0, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF]);
    }
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("deep");
    std::fs::write(&path, file(EXPLICIT, &data)).unwrap();
    let error = read(&path).unwrap_err();
    assert!(error.to_string().ends_with("nested deeper than 64 levels"), "{error}");
}

#[test]
fn an_empty_archive_holds_no_image() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("empty.zip");
    zip::ZipWriter::new(std::fs::File::create(&path).unwrap()).finish().unwrap();
    let error = read(&path).unwrap_err();
    assert!(error.to_string().ends_with("no DICOM image among 0 files"), "{error}");
}

#[test]
fn what_fuzzing_found_is_one_error_that_says_what_is_wrong() {
    // A parser that took 32 whole values and went on read a length of 3.8 GB in the 65th byte.
    let path = repository("fuzz/regressions/dicom/columns-of-65-bytes");
    let error = read(&path).unwrap_err();
    let said = "element (0028,0011): its length is no whole number of values";
    assert!(error.to_string().ends_with(said), "{error}");
}

#[test]
fn a_length_that_is_no_whole_number_of_values_is_refused_without_a_vr_too() {
    let mut data = Elements::default();
    for (element, value) in [(0x0005, &b"ISO_IR 100"[..]), (0x0016, b"1.2.840.10008.5.1.4.1.1.2 ")]
    {
        data.0.extend([0x08, 0, element as u8, 0]);
        data.0.extend((value.len() as u32).to_le_bytes());
        data.0.extend(value);
    }
    // Rows of three bytes, implicit VR.
    data.0.extend([0x28, 0, 0x10, 0, 3, 0, 0, 0, 1, 0, 0]);
    data.0.extend([0xE3; 64]);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("odd");
    std::fs::write(&path, file("1.2.840.10008.1.2", &data)).unwrap();
    let error = read(&path).unwrap_err();
    assert!(error.to_string().contains("element (0028,0010): its length"), "{error}");
}

#[test]
fn a_zip_entry_whose_checksum_does_not_hold_is_refused_by_name() {
    use mcubes::error::{Failure, Kind};
    use zip::write::SimpleFileOptions;
    let series = Series::axial(4);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("study.zip");
    for method in [zip::CompressionMethod::Stored, zip::CompressionMethod::Deflated] {
        let options = SimpleFileOptions::default().compression_method(method);
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for k in 0..4 {
            archive.start_file(format!("S{k}"), options).unwrap();
            std::io::Write::write_all(&mut archive, &series.image(k, k + 1)).unwrap();
        }
        let mut bytes = archive.finish().unwrap().into_inner();
        std::fs::write(&path, &bytes).unwrap();
        read(&path).unwrap();
        // The checksum of S2, in its own header and in the directory: other bytes were archived.
        let sum = crc32fast::hash(&series.image(2, 3)).to_le_bytes();
        let places = 0..bytes.len() - 4;
        let places: Vec<usize> = places.filter(|&at| bytes[at..at + 4] == sum).collect();
        for at in places {
            bytes[at] ^= 1;
        }
        std::fs::write(&path, &bytes).unwrap();
        let study = dicom::scan(&path, &ScanOptions::default()).unwrap();
        let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
        let error = mcubes::source::survey(volume, &mcubes::cancel::Cancel::new()).unwrap_err();
        assert_eq!(error.kind(), Kind::CorruptCompression, "{error}");
        assert!(error.to_string().starts_with("S2: "), "{error}");
    }
}
