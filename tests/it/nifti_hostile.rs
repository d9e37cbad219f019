//! NIfTI and raw files that are damaged on purpose: an error with a kind or the right samples,
//! never a panic, and no memory for what a header merely claims.

use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use mcubes::cancel::Cancel;
use mcubes::source::{self, Content, OpenOptions, RawInput, RawOptions, open_raw, sniff};
use mcubes::volume::{Meta, Note, StoredType};
use mcubes::{Error, Kind};

use crate::support::planes::{checksum, is_positioned, read_all};
use crate::support::repository;

fn read(path: &Path) -> Result<(Meta, Vec<f64>, Vec<Note>), Error> {
    read_all(source::open(path, &OpenOptions::default(), &Cancel::new()), path)
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// A NIfTI-1 or NIfTI-2 file of 4 x 3 x 2 samples of i16, spacing 1, sform the identity.
pub(crate) fn small(version: u8) -> Vec<u8> {
    let (size, offset) = if version == 1 { (348, 352) } else { (540, 544) };
    let mut file = vec![0; offset];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &i32::to_le_bytes(size));
    let dim = [3, 4, 3, 2, 1, 1, 1, 1];
    if version == 1 {
        dim.iter().enumerate().for_each(|(d, n)| put(40 + 2 * d, &i16::to_le_bytes(*n)));
        put(70, &4_i16.to_le_bytes());
        put(72, &16_i16.to_le_bytes());
        (0..8).for_each(|d| put(76 + 4 * d, &1_f32.to_le_bytes()));
        put(108, &352_f32.to_le_bytes());
        put(112, &1_f32.to_le_bytes());
        put(123, &[2]);
        put(254, &1_i16.to_le_bytes());
        for at in [280, 300, 320] {
            put(at, &1_f32.to_le_bytes());
        }
        put(344, b"n+1\0");
    } else {
        put(4, b"n+2\0\r\n\x1a\n");
        put(12, &4_i16.to_le_bytes());
        put(14, &16_i16.to_le_bytes());
        dim.iter().enumerate().for_each(|(d, n)| put(16 + 8 * d, &i64::from(*n).to_le_bytes()));
        (0..8).for_each(|d| put(104 + 8 * d, &1_f64.to_le_bytes()));
        put(168, &544_i64.to_le_bytes());
        put(176, &1_f64.to_le_bytes());
        put(348, &1_i32.to_le_bytes());
        put(500, &2_i32.to_le_bytes());
        for at in [400, 440, 480] {
            put(at, &1_f64.to_le_bytes());
        }
    }
    file.extend((0..24_i16).flat_map(|v| (v * 100).to_le_bytes()));
    file
}

fn small_values() -> String {
    checksum((0..24).map(|v| f64::from(v) * 100.0))
}

/// Reads the file plain and gzipped: neither may panic, and both must come to the same.
fn same_plain_and_gzipped(folder: &Folder, bytes: &[u8], what: &str) {
    let plain = read(&folder.put("v.nii", bytes));
    let packed = read(&folder.put("v.nii.gz", &gzip(bytes)));
    match (plain, packed) {
        (Ok((a, x, _)), Ok((b, y, _))) => {
            assert_eq!(checksum(x), checksum(y), "{what}");
            assert_eq!((a.grid, a.rescale, a.stored), (b.grid, b.rescale, b.stored), "{what}");
        }
        (Err(a), Err(b)) => {
            for e in [&a, &b] {
                assert!(!e.to_string().contains('\n') && e.kind() != Kind::Internal, "{what}: {e}");
            }
            // Where a plain file shows that an offset is wrong, a stream just ends.
            let cut = [Kind::TruncatedData, Kind::BadHeader];
            assert!(a.kind() == b.kind() || cut.contains(&a.kind()), "{what}: {a} / {b}");
        }
        (a, b) => panic!("{what}: plain {:?}, gzipped {:?}", a.map(|_| ()), b.map(|_| ())),
    }
}

#[test]
fn the_small_files_made_here_read_right() {
    let folder = Folder::new();
    for version in [1, 2] {
        let (_, values, notes) = read(&folder.put("v.nii", &small(version))).unwrap();
        assert_eq!(checksum(values), small_values());
        assert!(notes.is_empty());
    }
}

#[test]
fn every_header_field_may_hold_anything() {
    let folder = Folder::new();
    for version in [1_u8, 2] {
        let good = small(version);
        let header = if version == 1 { 348 } else { 540 };
        for at in 0..header {
            for width in [1, 2, 4, 8] {
                if at % width != 0 || at + width > header {
                    continue;
                }
                let words: [&[u8]; 9] = [
                    &[0; 8],
                    &1_u64.to_le_bytes(),
                    &[0xff; 8],
                    &i64::MAX.to_le_bytes()[8 - width..],
                    &i64::MIN.to_le_bytes()[8 - width..],
                    &f64::NAN.to_le_bytes()[8 - width..],
                    &f64::INFINITY.to_le_bytes()[8 - width..],
                    &1e30_f32.to_le_bytes().repeat(2),
                    &f32::NAN.to_le_bytes().repeat(2),
                ];
                for (n, word) in words.iter().enumerate() {
                    let mut bytes = good.clone();
                    let end = at + width.min(word.len());
                    bytes[at..end].copy_from_slice(&word[..end - at]);
                    // Gzipping all of them takes long and shows nothing new.
                    if (at + n) % 5 == 0 {
                        let what = format!("NIfTI-{version}, {width} bytes at {at}, value {n}");
                        same_plain_and_gzipped(&folder, &bytes, &what);
                    } else if let Err(e) = read(&folder.put("v.nii", &bytes)) {
                        assert_ne!(e.kind(), Kind::Internal, "{e}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_as_truncated() {
    let folder = Folder::new();
    for version in [1, 2] {
        let good = small(version);
        for end in 0..good.len() {
            let error = read(&folder.put("v.nii", &good[..end])).unwrap_err();
            assert_eq!(error.kind(), Kind::TruncatedData, "{end}: {error}");
            let error = read(&folder.put("v.nii.gz", &gzip(&good[..end]))).unwrap_err();
            assert_eq!(error.kind(), Kind::TruncatedData, "{end}, gzipped: {error}");
        }
    }
}

#[test]
fn a_gzip_stream_cut_anywhere_is_refused_and_a_changed_one_never_gives_other_samples() {
    let folder = Folder::new();
    let good = small(1);
    let packed = gzip(&good);
    for end in 2..packed.len() {
        let error = read(&folder.put("v.nii.gz", &packed[..end])).unwrap_err();
        assert_eq!(error.kind(), Kind::TruncatedData, "{end}: {error}");
    }
    // Bytes 4 to 9 of the header (time, level, system) change nothing.
    for at in (0..packed.len()).filter(|at| !(4..10).contains(at)) {
        let mut bytes = packed.clone();
        bytes[at] ^= 0x40;
        match read(&folder.put("v.nii.gz", &bytes)) {
            // Such as a match that reaches back to other zeros: another stream of the same bytes.
            Ok((_, values, _)) => assert_eq!(checksum(values), small_values()),
            Err(e) => assert_ne!(e.kind(), Kind::Internal),
        }
    }
}

#[test]
fn gzip_members_may_be_split_anywhere() {
    let folder = Folder::new();
    let good = small(2);
    for at in [0, 1, 4, 347, 348, 349, 540, 544, 545, 560, good.len()] {
        let mut bytes = gzip(&good[..at]);
        bytes.extend(gzip(&[]));
        bytes.extend(gzip(&good[at..]));
        let (_, values, _) = read(&folder.put("v.nii", &bytes)).unwrap();
        assert_eq!(checksum(values), small_values(), "split at {at}");
    }
}

#[test]
fn bytes_after_the_samples_and_after_gzip_are_noted() {
    let folder = Folder::new();
    let mut long = small(1);
    long.extend([7; 11]);
    let (meta, ..) = read(&folder.put("v.nii", &long)).unwrap();
    assert_eq!(meta.notes, [Note::TrailingBytes { bytes: 11 }]);
    let mut packed = gzip(&long);
    packed.extend([0; 1000]);
    let (_, _, notes) = read(&folder.put("v.nii.gz", &packed)).unwrap();
    assert_eq!(notes, [Note::TrailingBytes { bytes: 11 }, Note::AfterGzip { bytes: 1000 }]);
}

#[test]
fn a_file_that_shrinks_while_it_is_read_is_truncated_with_both_byte_counts() {
    let folder = Folder::new();
    let path = folder.put("v.nii", &small(1));
    let volume = source::open(&path, &OpenOptions::default(), &Cancel::new()).unwrap();
    assert!(is_positioned(&volume));
    std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(352 + 30).unwrap();
    let error = read_all(Ok(volume), &path).unwrap_err();
    assert_eq!(error.kind(), Kind::TruncatedData);
    let text = error.to_string();
    assert!(text.ends_with("the data end after 1 of 2 planes (30 of 48 bytes)"), "{text}");
}

#[test]
fn a_4d_file_without_its_last_bytes_is_refused_for_any_volume() {
    let folder = Folder::new();
    let mut bytes = small(1);
    bytes[40..42].copy_from_slice(&4_i16.to_le_bytes());
    bytes[48..50].copy_from_slice(&2_i16.to_le_bytes());
    bytes.extend([0; 47]);
    for path in [folder.put("v.nii", &bytes), folder.put("v.nii.gz", &gzip(&bytes))] {
        let error = read(&path).unwrap_err();
        let text = error.to_string();
        assert!(text.ends_with("the data end after 3 of 4 planes (95 of 96 bytes)"), "{text}");
    }
}

#[test]
fn a_gzip_file_too_small_for_its_claim_is_refused_before_any_plane() {
    let folder = Folder::new();
    let mut bytes = small(2);
    for d in 0..3 {
        bytes[24 + 8 * d..32 + 8 * d].copy_from_slice(&20_000_i64.to_le_bytes());
    }
    let path = folder.put("v.nii.gz", &gzip(&bytes));
    let error = source::open(&path, &OpenOptions::default(), &Cancel::new()).err().unwrap();
    assert_eq!(error.kind(), Kind::TruncatedData, "{error}");
}

#[test]
fn either_part_of_a_pair_may_be_named_and_gzipped() {
    let folder = Folder::new();
    let mut header = small(1);
    header[344..348].copy_from_slice(b"ni1\0");
    header[108..112].copy_from_slice(&0_f32.to_le_bytes());
    let image = header.split_off(352);
    header.truncate(348);
    for (h, i) in
        [("a.hdr", "a.img"), ("b.hdr", "b.img.gz"), ("c.hdr.gz", "c.img"), ("D.HDR", "D.IMG.GZ")]
    {
        let pack = |name: &str, bytes: &[u8]| {
            let packed = name.to_ascii_lowercase().ends_with(".gz");
            folder.put(name, &if packed { gzip(bytes) } else { bytes.to_vec() })
        };
        for path in [pack(h, &header), pack(i, &image)] {
            let path = if path.ends_with(h) {
                pack(i, &image);
                path
            } else {
                path
            };
            assert_eq!(sniff(&path).unwrap(), Content::Nifti, "{}", path.display());
            let (_, values, _) = read(&path).unwrap();
            assert_eq!(checksum(values), small_values(), "{}", path.display());
        }
    }
    let lonely = folder.put("lonely.img", &image);
    assert_eq!(sniff(&lonely).unwrap(), Content::Unknown);
    assert_eq!(read(&lonely).unwrap_err().kind(), Kind::TruncatedData);
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_read_in_order() {
    let folder = Folder::new();
    for bytes in [small(1), gzip(&small(2))] {
        let path = folder.0.path().join("pipe.nii");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.is_ok_and(|s| s.success()), "mkfifo makes a pipe");
        assert_eq!(sniff(&path).unwrap(), Content::Stream);
        let writer = std::thread::spawn({
            let path = path.clone();
            move || std::fs::write(path, bytes).unwrap()
        });
        let (_, values, _) = read(&path).unwrap();
        assert_eq!(checksum(values), small_values());
        writer.join().unwrap();
        std::fs::remove_file(&path).unwrap();
    }
}

#[test]
fn other_formats_are_named() {
    let folder = Folder::new();
    let mut dicom = vec![0; 128];
    dicom.extend(b"DICM\x02\0\0\0UL\x04\0");
    dicom.resize(800, 0);
    let bare = [&b"\x08\0\x05\0CS\x0a\0ISO_IR 100"[..], &[0; 500]].concat();
    let cases: [(&str, &[u8], Content); 8] = [
        ("a.dcm", &dicom, Content::Dicom),
        ("b.dcm", &bare, Content::Dicom),
        ("a.zip", b"PK\x03\x04rest", Content::Zip),
        ("a.nrrd", b"NRRD0004\ntype: short\n", Content::Foreign("NRRD")),
        ("a.png", b"\x89PNG\r\n\x1a\n0000", Content::Foreign("PNG")),
        ("a.gz", &gzip(b"text"), Content::Gzip),
        ("a.txt", &[b'x'; 1000], Content::Unknown),
        ("a.nii", &small(1), Content::Nifti),
    ];
    for (name, bytes, content) in cases {
        let path = folder.put(name, bytes);
        assert_eq!(sniff(&path).unwrap(), content, "{name}");
        if content != Content::Nifti && content != Content::Gzip {
            assert_eq!(read(&path).unwrap_err().kind(), Kind::UnknownFormat, "{name}");
        }
    }
    assert_eq!(sniff(folder.0.path()).unwrap(), Content::Folder);
    let missing = sniff(&folder.0.path().join("none")).unwrap_err();
    assert_eq!(missing.kind(), Kind::NotFound);
}

#[test]
fn a_raw_size_that_does_not_fit_names_what_would() {
    let folder = Folder::new();
    let path = folder.put("v.raw", &[0; 20 * 10 * 7 * 2]);
    let gz = folder.put("v.raw.gz", &gzip(&[0; 20 * 10 * 7 * 2]));
    let hint = |dims, stored, offset| {
        let options = RawOptions { offset_bytes: offset, ..RawOptions::new(dims, stored) };
        [&path, &gz].map(|path| {
            let opened = open_raw(RawInput::Path(path.clone()), &options, &Cancel::new());
            let error = read_all(opened, path).unwrap_err();
            assert_eq!(error.kind(), Kind::SizeMismatch, "{error}");
            error.hint()
        })
    };
    let some = |text: &str| Some(text.to_owned());
    let both = |text: &str| [some(text), some(text)];
    assert_eq!(hint([20, 10, 7], StoredType::U8, 0), both("--type u16 or i16 would fit"));
    assert_eq!(hint([20, 10, 5], StoredType::I16, 0), both("--dims 20x10x7 would fit"));
    assert_eq!(hint([20, 10, 9], StoredType::I16, 0)[0], some("--dims 20x10x7 would fit"));
    assert_eq!(
        hint([20, 9, 7], StoredType::I16, 0),
        both("--offset 280 would fit, if a header of that size comes first")
    );
    assert_eq!(hint([20, 10, 7], StoredType::I16, 9999), [None, None]);
}

#[test]
fn raw_samples_that_happen_to_begin_like_gzip_are_read_as_they_are() {
    let folder = Folder::new();
    let mut bytes = vec![0; 24];
    bytes[..3].copy_from_slice(&[0x1f, 0x8b, 8]);
    let path = folder.put("v.raw", &bytes);
    let opened = open_raw(
        RawInput::Path(path.clone()),
        &RawOptions::new([4, 3, 2], StoredType::U8),
        &Cancel::new(),
    );
    let (_, values, _) = read_all(opened, &path).unwrap();
    assert_eq!(values[..3], [31.0, 139.0, 8.0]);
}

#[test]
fn raw_numbers_that_make_no_grid_are_refused() {
    let path = repository("testdata/raw/phantom_u8_le.raw");
    let with = |change: fn(&mut RawOptions)| {
        let mut options = RawOptions::new([20, 24, 28], StoredType::U8);
        change(&mut options);
        open_raw(RawInput::Path(path.clone()), &options, &Cancel::new()).err().map(|e| e.kind())
    };
    assert_eq!(with(|_| {}), None);
    assert_eq!(with(|o| o.spacing_mm[1] = 0.0), Some(Kind::BadAffine));
    assert_eq!(with(|o| o.spacing_mm[1] = -1.0), Some(Kind::BadAffine));
    assert_eq!(with(|o| o.spacing_mm[2] = f64::NAN), Some(Kind::BadAffine));
    assert_eq!(with(|o| o.spacing_mm[2] = f64::INFINITY), Some(Kind::BadAffine));
    assert_eq!(with(|o| o.origin_mm[0] = f64::NAN), Some(Kind::BadAffine));
    assert_eq!(with(|o| o.dims[0] = -1), Some(Kind::BadDims));
    assert_eq!(with(|o| o.dims = [i64::MAX; 3]), Some(Kind::BadDims));
    assert_eq!(with(|o| o.offset_bytes = u64::MAX), Some(Kind::BadDims));
}
