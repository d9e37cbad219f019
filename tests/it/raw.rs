//! Samples without a header, against numpy.

use std::path::Path;

use mcubes::cancel::Cancel;
use mcubes::source::{RawInput, RawOptions, open_raw};
use mcubes::volume::{Meta, Note, StoredType};
use mcubes::{Error, Kind};
use serde_json::Value;

use crate::support::expected::{Entry, compare_values, entries, floats};
use crate::support::nifti::gzip_of_size;
use crate::support::planes::read_all;

fn options(entry: &Value) -> RawOptions {
    let word = entry["type"].as_str().unwrap();
    let stored = StoredType::ALL.into_iter().find(|t| t.as_str() == word).unwrap();
    let three = |key: &str| <[f64; 3]>::try_from(floats(&entry[key])).unwrap();
    RawOptions {
        dims: floats(&entry["dims"])
            .iter()
            .map(|&n| n as i64)
            .collect::<Vec<_>>()
            .try_into()
            .unwrap(),
        big_endian: entry["endian"] == "big",
        spacing_mm: three("spacing"),
        origin_mm: three("origin"),
        offset_bytes: entry["offset"].as_u64().unwrap(),
        stored,
    }
}

fn read(path: &Path, options: &RawOptions) -> Result<(Meta, Vec<f64>, Vec<Note>), Error> {
    read_all(open_raw(RawInput::Path(path.to_owned()), options, &Cancel::new()), path)
}

fn of_status(status: &str) -> Vec<Entry> {
    let found: Vec<Entry> = entries("raw").into_iter().filter(|e| e.is(status)).collect();
    assert!(!found.is_empty());
    found
}

#[test]
fn every_good_file_reads_as_numpy_reads_it() {
    for Entry { root, name: path, facts: entry } in &of_status("good") {
        let (meta, stored, _) =
            read(&root.join(path), &options(entry)).unwrap_or_else(|e| panic!("{e}"));
        compare_values(path, entry, &meta, &stored);
        assert_eq!(meta.grid.affine.spacing().to_vec(), floats(&entry["spacing"]), "{path}");
        assert_eq!(meta.grid.affine.column(3).to_vec(), floats(&entry["origin"]), "{path}");
    }
}

#[test]
fn every_bad_file_is_refused_with_its_kind() {
    for Entry { root, name: path, facts: entry } in &of_status("bad") {
        let Err(error) = read(&root.join(path), &options(entry)) else { panic!("{path} was read") };
        println!("{error}  [{}]  {}", error.kind(), error.hint().unwrap_or_default());
        let kind = match entry["error"].as_str().unwrap() {
            "bad-dims" => Kind::BadDims,
            "bad-spacing" => Kind::BadAffine,
            _ => Kind::SizeMismatch,
        };
        assert_eq!(error.kind(), kind, "{path}: {error}");
    }
}

#[test]
fn doubtful_files_are_refused_or_read_with_the_right_values() {
    for Entry { root, name: path, facts: entry } in &of_status("either") {
        match read(&root.join(path), &options(entry)) {
            Err(error) => assert_eq!(error.kind(), Kind::SizeMismatch, "{path}: {error}"),
            Ok((meta, stored, _)) => compare_values(path, entry, &meta, &stored),
        }
    }
}

#[cfg(unix)]
#[test]
fn a_stream_without_an_end_is_one_of_the_wrong_size() {
    let sandbox = crate::support::sandbox::Sandbox::new();
    let (said, reported) =
        sandbox.ends(1, "/dev/zero --dims 4x4x4 --type u8 --iso 40 -o a.stl --json");
    assert_eq!(reported[0]["error"]["kind"], "size-mismatch", "{said}");
    assert_eq!(sandbox.files(), [""; 0]);
}

#[test]
fn raw_bytes_that_begin_a_member_nobody_can_read_are_no_gzip() {
    let folder = tempfile::tempdir().unwrap();
    for head in [[0x1f, 0x8b, 7, 0], [0x1f, 0x8b, 8, 0x20], [0x1f, 0x8b, 8, 0xff]] {
        let mut bytes = vec![0; 25];
        bytes[..4].copy_from_slice(&head);
        let path = folder.path().join("v.raw");
        std::fs::write(&path, bytes).unwrap();
        let options = RawOptions::new([4, 3, 2], StoredType::U8);
        let error = open_raw(RawInput::Path(path), &options, &Cancel::new()).err().unwrap();
        assert_eq!(error.kind(), Kind::SizeMismatch, "{head:?}: {error}");
    }
}

#[test]
fn a_gzipped_raw_file_may_have_just_the_size_of_its_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.raw.gz");
    std::fs::write(&path, gzip_of_size(&[7; 48], 48)).unwrap();
    let (_, values, _) = read(&path, &RawOptions::new([4, 3, 2], StoredType::I16)).unwrap();
    assert_eq!(values, [f64::from(0x0707); 24]);
}
