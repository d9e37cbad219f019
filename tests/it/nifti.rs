//! NIfTI files, against what nibabel and numpy see.

use std::path::Path;

use mcubes::cancel::Cancel;
use mcubes::geom::{Affine, orientation};
use mcubes::source::{self, OpenOptions};
use mcubes::volume::{Meta, Note};
use mcubes::{Error, Kind};
use serde_json::Value;

use super::nifti_hostile::small;
use crate::support::expected::{Entry, compare_values, entries, floats};
use crate::support::nifti::gzip_of_size;
use crate::support::planes::{checksum, read_all};
use crate::support::repository;

fn read(path: &Path, volume: Option<usize>) -> Result<(Meta, Vec<f64>, Vec<Note>), Error> {
    read_all(source::open(path, &OpenOptions { volume }, &Cancel::new()), path)
}

fn of_status(status: &str) -> Vec<Entry> {
    let found: Vec<Entry> = entries("nifti").into_iter().filter(|e| e.is(status)).collect();
    assert!(!found.is_empty());
    found
}

fn compare_geometry(what: &str, entry: &Value, meta: &Meta) {
    let shape: Vec<u64> =
        entry["shape"].as_array().unwrap().iter().map(|v| v.as_u64().unwrap()).collect();
    let dims = meta.grid.dims.to_array().map(|n| n as u64);
    let wanted = [0, 1, 2].map(|d| shape.get(d).copied().unwrap_or(1));
    assert_eq!(dims, wanted, "{what}: dims");
    assert_eq!(meta.n_volumes as u64, entry["volumes"].as_u64().unwrap(), "{what}: volumes");
    let stored = match meta.stored.as_str().split_at(1) {
        ("u", bits) => format!("uint{bits}"),
        ("i", bits) => format!("int{bits}"),
        (_, bits) => format!("float{bits}"),
    };
    assert_eq!(stored, entry["dtype"].as_str().unwrap(), "{what}: type");
    assert_eq!(meta.rescale.slope(), entry["slope"].as_f64().unwrap(), "{what}: slope");
    assert_eq!(meta.rescale.inter(), entry["inter"].as_f64().unwrap(), "{what}: intercept");

    let in_mm = entry.get("affine_mm");
    let rows = in_mm.unwrap_or(&entry["affine"]).as_array().unwrap();
    let unit = match entry["xyzt_units"].as_u64().unwrap() & 7 {
        1 => 1e3,
        3 => 1e-3,
        _ => 1.0,
    };
    let spacing = floats(&entry["voxel_size"]).into_iter().fold(0.0, f64::max) * unit;
    let tolerance = 1e-5 * spacing * wanted.into_iter().max().unwrap() as f64;
    for (row, got) in rows.iter().zip(meta.grid.affine.rows()) {
        for (want, got) in floats(row).into_iter().zip(got) {
            assert!((want - got).abs() <= tolerance, "{what}: affine {got}, not {want}");
        }
    }
    for (want, got) in floats(&entry["voxel_size"]).into_iter().zip(meta.grid.affine.spacing()) {
        assert!((want * unit - got).abs() <= tolerance, "{what}: spacing {got}, not {want}");
    }
    assert_eq!(
        meta.grid.affine.determinant() < 0.0,
        entry["determinant_negative"].as_bool().unwrap(),
        "{what}: handedness"
    );
    assert_eq!(orientation(&meta.grid.affine), entry["axcodes"].as_str().unwrap(), "{what}");
    let from_pixdim = meta.notes.contains(&Note::AffineFromPixdim);
    assert_eq!(from_pixdim, entry["affine_source"] == "pixdim", "{what}: where from");
}

/// The kinds that a class of malformed file may be refused with.
fn kinds(class: &str) -> &'static [Kind] {
    match class {
        "bad-magic" => &[Kind::BadHeader, Kind::UnknownFormat, Kind::NotFound, Kind::TruncatedData],
        "bad-bitpix" | "bad-byte-order" | "bad-header-size" | "bad-offset" | "bad-scaling" => {
            &[Kind::BadHeader]
        }
        "bad-dims" => &[Kind::BadDims],
        "bad-affine" => &[Kind::BadAffine],
        "bad-gzip" => &[Kind::CorruptCompression],
        "is-a-directory" => &[Kind::Unreadable],
        "missing-file" => &[Kind::NotFound],
        "not-nifti" => &[Kind::UnknownFormat],
        "truncated-data" | "truncated-gzip" | "truncated-header" => &[Kind::TruncatedData],
        "unsupported-datatype" => &[Kind::UnsupportedType],
        other => panic!("no kind for {other}"),
    }
}

#[test]
fn every_good_file_reads_as_nibabel_reads_it() {
    for Entry { root, name: path, facts: entry } in &of_status("good") {
        let file = root.join(path);
        let (meta, stored, _) = read(&file, None).unwrap_or_else(|e| panic!("{e}"));
        compare_geometry(path, entry, &meta);
        compare_values(path, entry, &meta, &stored);
        assert_eq!(source::volumes(&file).unwrap().len(), meta.n_volumes, "{path}");
    }
}

#[test]
fn every_volume_of_a_4d_file_is_the_one_asked_for() {
    for Entry { root, name: path, facts: entry } in &entries("nifti") {
        let Some(volumes) = entry["crc_stored_volumes"].as_array() else { continue };
        for (at, crc) in volumes.iter().enumerate() {
            let (meta, stored, _) = read(&root.join(path), Some(at + 1)).unwrap();
            assert_eq!(checksum(stored), crc.as_str().unwrap(), "{path}: volume {}", at + 1);
            assert_eq!(meta.volume_number, at + 1);
        }
        let beyond = read(&root.join(path), Some(entry["volumes"].as_u64().unwrap() as usize + 1));
        assert_eq!(beyond.unwrap_err().kind(), Kind::BadDims, "{path}");
    }
}

#[test]
fn every_bad_file_is_refused_with_its_kind_and_one_line() {
    for Entry { root, name: path, facts: entry } in &of_status("bad") {
        let Err(error) = read(&root.join(path), None) else { panic!("{path} was read") };
        println!("{error}  [{}]  {}", error.kind(), error.hint().unwrap_or_default());
        let class = entry["error"].as_str().unwrap();
        assert!(kinds(class).contains(&error.kind()), "{path} ({class}): {error}");
        assert!(!error.to_string().contains('\n'));
    }
}

#[test]
fn doubtful_files_are_refused_or_read_with_the_right_values() {
    let all = entries("nifti");
    let of = |path: &str| all.iter().rev().find(|e| e.name == path).map(|e| e.facts.clone());
    for Entry { root, name: path, facts: entry } in &of_status("either") {
        match read(&root.join(path), None) {
            Err(error) => {
                println!("{error}  [{}]", error.kind());
                if let Some(class) = entry["error"].as_str() {
                    assert!(kinds(class).contains(&error.kind()), "{path} ({class}): {error}");
                }
            }
            Ok((meta, stored, _)) => {
                println!("{path}: read");
                let like = entry["same_values_as"].as_str().map(|p| of(p).unwrap());
                let entry = like.as_ref().unwrap_or(entry);
                if entry["crc_stored"].is_string() {
                    compare_geometry(path, entry, &meta);
                    compare_values(path, entry, &meta, &stored);
                }
            }
        }
    }
}

#[test]
fn letters_of_oblique_and_sheared_affines_are_nibabels() {
    let text = std::fs::read_to_string(repository("testdata/orientation.json")).unwrap();
    let all: Vec<Value> = serde_json::from_str(&text).unwrap();
    for entry in &all {
        let rows: Vec<Vec<f64>> = entry["affine"].as_array().unwrap().iter().map(floats).collect();
        let affine =
            Affine::from_rows([0, 1, 2].map(|r| <[f64; 4]>::try_from(&rows[r][..]).unwrap()));
        assert_eq!(orientation(&affine), entry["axcodes"].as_str().unwrap(), "{rows:?}");
    }
    assert_eq!(all.len(), 240);
}

/// A second reader, for what it can read: NIfTI-1 with little to go wrong.
#[test]
fn headers_agree_with_the_nifti_crate() {
    use nifti::NiftiHeader;
    let mut n = 0;
    for entry in of_status("good") {
        let Ok(theirs) = NiftiHeader::from_file(entry.path()) else { continue };
        let meta = &source::volumes(&entry.path()).unwrap()[0];
        let dims = meta.grid.dims.to_array();
        for d in 0..usize::from(theirs.dim[0]).min(3) {
            assert_eq!(dims[d], usize::from(theirs.dim[d + 1]), "{}", entry.name);
        }
        assert_eq!(meta.stored.size() * 8, usize::try_from(theirs.bitpix).unwrap());
        if theirs.sform_code > 0 && theirs.xyzt_units & 7 == 2 {
            let rows = [theirs.srow_x, theirs.srow_y, theirs.srow_z].map(|r| r.map(f64::from));
            assert_eq!(meta.grid.affine.rows(), &rows, "{}", entry.name);
        }
        if theirs.scl_slope.is_normal() {
            assert_eq!(meta.rescale.slope(), f64::from(theirs.scl_slope), "{}", entry.name);
            assert_eq!(meta.rescale.inter(), f64::from(theirs.scl_inter), "{}", entry.name);
        }
        n += 1;
    }
    assert!(n > 50, "{n} headers");
}

#[test]
fn the_samples_of_a_pair_may_begin_like_gzip() {
    let folder = tempfile::tempdir().unwrap();
    let synth = repository("testdata/nifti/synth");
    let [header, image] = ["a.hdr", "a.img"].map(|name| folder.path().join(name));
    std::fs::copy(synth.join("pair_i16_le.hdr"), &header).unwrap();
    let mut samples = std::fs::read(synth.join("pair_i16_le.img")).unwrap();
    samples[..2].copy_from_slice(&[0x1f, 0x8b]);
    std::fs::write(&image, &samples).unwrap();
    for path in [header, image] {
        let (meta, values, _) = read(&path, None).unwrap();
        assert_eq!(values[0], meta.rescale.real(f64::from(i16::from_le_bytes([0x1f, 0x8b]))));
        assert_eq!(values.len() * 2, samples.len());
        assert_eq!(source::sniff(&path).unwrap(), source::Content::Nifti);
    }
}

#[test]
fn a_gzipped_image_may_have_just_the_size_of_its_samples() {
    let folder = tempfile::tempdir().unwrap();
    let samples = [7; 48];
    let (header, _) = pair(&samples);
    std::fs::write(folder.path().join("a.hdr"), header).unwrap();
    let image = folder.path().join("a.img.gz");
    std::fs::write(&image, gzip_of_size(&samples, samples.len())).unwrap();
    let (_, values, _) = read(&image, None).unwrap();
    assert_eq!(values, [f64::from(0x0707); 24]);
}

/// A file of 4 x 3 x 2 samples with other bytes at some places, written to `folder`.
fn changed(folder: &Path, name: &str, changes: &[(usize, &[u8])]) -> std::path::PathBuf {
    let mut bytes = small(1);
    for (at, new) in changes {
        bytes[*at..at + new.len()].copy_from_slice(new);
    }
    std::fs::write(folder.join(name), bytes).unwrap();
    folder.join(name)
}

/// nibabel's base affine takes as many pixdims as there are dimensions, and 1 for the others.
#[test]
fn dimensions_that_are_not_there_have_a_step_of_1() {
    let folder = tempfile::tempdir().unwrap();
    let pixdims: Vec<u8> = [2_f32, 3.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let zero = "pixdim[3] is 0: taken as 1 mm";
    for (n_dims, steps, is_told) in
        [(1, [-2.0, 1.0, 1.0], false), (2, [-2.0, 3.0, 1.0], false), (3, [-2.0, 3.0, 1.0], true)]
    {
        let file = changed(folder.path(), "v.nii", &[(40, &[n_dims]), (254, &[0]), (80, &pixdims)]);
        let (meta, _, notes) = read(&file, None).unwrap();
        let rows = meta.grid.affine.rows();
        assert_eq!([0, 1, 2].map(|d| rows[d][d]), steps, "{n_dims}");
        let is_there = meta.notes.iter().chain(&notes).any(|note| note.to_string() == zero);
        assert_eq!(is_there, is_told, "{n_dims}");
    }
}

#[test]
fn one_slice_without_a_step_is_as_thick_as_a_millimetre() {
    let folder = tempfile::tempdir().unwrap();
    let zero = 0_f32.to_le_bytes();
    let flat = [(46, &[1][..]), (320, &zero), (284, &[0, 0, 0x80, 0x3f])];
    let (meta, _, _) = read(&changed(folder.path(), "v.nii", &flat), None).unwrap();
    assert_eq!(meta.grid.affine.column(1), [1.0, 1.0, 0.0]);
    assert_eq!(meta.grid.affine.column(2), [0.0, 0.0, 1.0]);
    let told = meta.notes.iter().any(|note| note.to_string().contains("no step along k"));
    assert!(told, "{:?}", meta.notes);
    // Of two slices it would put one upon the other.
    let error = read(&changed(folder.path(), "v.nii", &flat[1..]), None).unwrap_err();
    assert_eq!(error.kind(), Kind::BadAffine, "{error}");
}

/// The header of a pair, and its samples with some first bytes.
fn pair(begin: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let mut header = small(1);
    header[344..348].copy_from_slice(b"ni1\0");
    header[108..112].fill(0);
    let mut image = header.split_off(352);
    header.truncate(348);
    image[..begin.len()].copy_from_slice(begin);
    (header, image)
}

#[test]
fn the_other_file_of_a_pair_is_the_one_that_is_named_most_alike() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let gzip = |bytes: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let (header, packed) = pair(&7_i16.to_le_bytes());
    let (_, plain) = pair(&9_i16.to_le_bytes());
    for (name, bytes) in [
        ("a.hdr.gz", gzip(&header)),
        ("a.img.gz", gzip(&packed)),
        ("a.img", plain),
        ("a.hdr", header.clone()),
        ("B.HDR.gz", gzip(&header)),
        ("b.img.gz", gzip(&packed)),
        ("B.IMG.gz", gzip(&packed)),
    ] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let first = |name: &str| read(&folder.path().join(name), None).unwrap().1[0];
    for (name, value) in [("a.hdr.gz", 7.0), ("a.hdr", 9.0), ("a.img.gz", 7.0), ("a.img", 9.0)] {
        assert_eq!(first(name), value, "{name}");
    }
    let files = source::files(&folder.path().join("B.HDR.gz"));
    assert_eq!(files[1], folder.path().join("B.IMG.gz"));
}

#[test]
fn the_samples_of_a_pair_may_begin_like_a_header() {
    let folder = tempfile::tempdir().unwrap();
    let [header, image] = ["a.hdr", "a.img"].map(|name| folder.path().join(name));
    for size in [348_i32, 540, i32::swap_bytes(348)] {
        let (head, samples) = pair(&size.to_le_bytes());
        std::fs::write(&header, head).unwrap();
        std::fs::write(&image, samples).unwrap();
        let [a, b] = [&header, &image].map(|path| read(path, None).unwrap().1);
        assert_eq!(a, b, "{size}");
        assert_eq!(source::sniff(&image).unwrap(), source::Content::Nifti);
    }
}

#[test]
fn the_files_of_a_pair_are_known_by_its_header_whatever_it_is_called() {
    let folder = tempfile::tempdir().unwrap();
    let (header, image) = pair(&[]);
    let [other, samples] = ["k.nii", "k.img"].map(|name| folder.path().join(name));
    std::fs::write(&other, header).unwrap();
    std::fs::write(&samples, image).unwrap();
    assert_eq!(source::files(&other), [other.clone(), samples]);
    let alone = changed(folder.path(), "alone.nii", &[]);
    assert_eq!(source::files(&alone), [alone]);
}
