//! The values of a DICOM series are the same however its files write them.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use mcubes::geom::Space;
use mcubes::mesh::{Position, Triangle};
use mcubes::pipeline::{RunOptions, SurfaceOptions, mesh_placed};
use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use mcubes::source::{crop, pad_out};
use mcubes::volume::{Inside, Meta, Side};
use ndarray::Array3;
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{EXPLICIT, Elements, PIXELS, Series};
use crate::support::ljpeg;

const JPEG_LOSSLESS: &str = "1.2.840.10008.1.2.4.70";

const POSITION: (u16, u16) = (0x0020, 0x0032);
const BITS_STORED: (u16, u16) = (0x0028, 0x0101);
const HIGH_BIT: (u16, u16) = (0x0028, 0x0102);
const SIGN: (u16, u16) = (0x0028, 0x0103);
/// `RescaleIntercept` and `RescaleSlope`.
const RESCALED: [(u16, u16); 2] = [(0x0028, 0x1052), (0x0028, 0x1053)];

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

#[test]
fn cells_that_are_padding_as_stored_are_padding_where_bits_stored_cannot_hold_it() {
    let (series, plain) = series();
    // Without the upper bits the cell would be 2096, and 424 when real.
    for (sign, vr, padding) in [(0, *b"US", 0xF830_u16), (0, *b"SS", 0xF830), (1, *b"SS", 0x8000)] {
        let folder = TempDir::new().unwrap();
        let at = |index: usize| index % 40 < 4;
        series.write_as(folder.path(), EXPLICIT, |_, data| {
            let cells = words(data).into_iter().map(|w| w / 4).enumerate();
            let cells = cells.map(|(index, w)| if at(index) { padding } else { w });
            data.set(PIXELS, *b"OW", &cells.flat_map(u16::to_le_bytes).collect::<Vec<u8>>());
            set_bits(data, 12, 11, sign);
            data.set((0x0028, 0x0120), vr, &padding.to_le_bytes());
        });
        let (meta, found) = read(folder.path());
        let value = if sign == 1 { f64::from(padding as i16) } else { f64::from(padding) };
        assert_eq!(meta.padding.map(|p| (p.low, p.high)), Some((value, value)));
        for (index, (found, plain)) in found.iter().zip(&plain).enumerate() {
            let stored = (plain + 100.0).floor();
            let wanted = if at(index) { value } else { stored };
            assert_eq!(*found, wanted * 0.25 - 100.0, "{index}");
        }
    }
}

#[test]
fn known_elements_of_unknown_vr_are_read_as_the_standard_has_them() {
    let (series, plain) = series();
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let place = read(folder.path()).0.grid;
    let folder = TempDir::new().unwrap();
    // SeriesInstanceUID, ImagePositionPatient, Rows and the rescale: text and numbers.
    let unknown = [(0x0020, 0x000E), POSITION, (0x0028, 0x0010), RESCALED[0], RESCALED[1]];
    series.write_as(folder.path(), EXPLICIT, |_, data| {
        for tag in unknown {
            let value = data.value(tag).to_vec();
            data.set(tag, *b"UN", &value);
        }
    });
    let (meta, found) = read(folder.path());
    assert_eq!(found, plain);
    assert_eq!(meta.grid, place);
}

/// An element of implicit VR little endian; without a length where its value is a sequence.
fn implicit(tag: (u16, u16), value: &[u8]) -> Vec<u8> {
    let length = if value.starts_with(&[0xFE, 0xFF]) { u32::MAX } else { value.len() as u32 };
    let mut out = [tag.0.to_le_bytes(), tag.1.to_le_bytes()].concat();
    out.extend(length.to_le_bytes());
    out.extend(value);
    out
}

/// One item with these elements, and the end of its sequence.
fn sequence(elements: &[u8]) -> Vec<u8> {
    let item = [0xFE, 0xFF, 0, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF];
    let ends = [0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0, 0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0];
    [&item, elements, &ends].concat()
}

#[test]
fn functional_groups_of_unknown_vr_are_sequences_in_implicit_vr() {
    let (series, plain) = series();
    for is_defined in [false, true] {
        let found = written(&series, EXPLICIT, |_, data| {
            let position = data.value(POSITION).to_vec();
            let rescale = RESCALED.map(|tag| implicit(tag, data.value(tag))).concat();
            for tag in RESCALED.into_iter().chain([POSITION]) {
                data.remove(tag);
            }
            let groups = [
                implicit((0x0020, 0x9113), &sequence(&implicit(POSITION, &position))),
                implicit((0x0028, 0x9145), &sequence(&rescale)),
            ];
            let groups = sequence(&groups.concat());
            // PerFrameFunctionalGroupsSequence.
            data.set((0x5200, 0x9230), *b"UN", &groups);
            if !is_defined {
                data.leave_length_open((0x5200, 0x9230));
            }
        });
        assert_eq!(found, plain, "{is_defined}");
    }
}

#[test]
fn the_private_syntax_of_ge_has_its_pixels_big_endian() {
    let (series, plain) = series();
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), "1.2.840.113619.5.2", |_, data| {
        let swapped: Vec<u8> = words(data).iter().flat_map(|w| w.to_be_bytes()).collect();
        data.set(PIXELS, *b"OW", &swapped);
        data.make_implicit();
    });
    let (meta, found) = read(folder.path());
    assert_eq!(found, plain);
    assert_eq!(dicom::syntax_names(&meta.series.unwrap()), "GE private, big endian pixels");
}

/// The mesh of a folder at a level, padding taken out.
fn mesh(folder: &Path, iso: f64) -> (Vec<Position>, Vec<Triangle>) {
    let study = dicom::scan(folder, &ScanOptions::default()).unwrap();
    let volume = study.open(study.default().unwrap(), &OpenOptions::default()).unwrap();
    let volume = crop(volume, &[1..39, 1..35, 0..5]).unwrap();
    let volume = pad_out(volume, Inside { iso, side: Side::AtLeast });
    let grid = volume.meta.grid.clone();
    let [nx, ny, nz] = grid.dims.to_array();
    let values = Array3::from_shape_vec((nz, ny, nx), values(volume).unwrap()).unwrap();
    let (surface, run) = (SurfaceOptions::at(iso), RunOptions::default());
    let mesh = mesh_placed(values.view(), &grid, Space::Ras, &surface, &run).unwrap();
    (mesh.vertices.to_vec(), mesh.triangles.to_vec())
}

/// A series whose first twelve columns are stored as `padding`, with another slope in each slice
/// and, if `named`, the padding said to be that.
fn padded(series: &Series, padding: u16, named: impl Fn(usize) -> bool) -> TempDir {
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), EXPLICIT, |k, data| {
        let cols = usize::from(series.cols);
        let stored = words(data);
        let pad = |(at, w): (usize, &u16)| if at % cols < 12 { padding } else { *w };
        let pixels: Vec<u8> =
            stored.iter().enumerate().map(pad).flat_map(u16::to_le_bytes).collect();
        data.set(PIXELS, *b"OW", &pixels);
        data.set(RESCALED[1], *b"DS", format!("0.25{k}").as_bytes());
        if named(k) {
            data.set((0x0028, 0x0120), *b"US", &padding.to_le_bytes());
        }
    });
    folder
}

/// The place along x, in RAS mm, halfway from the last padded column to the next.
fn edge_of_padding(series: &Series) -> f64 {
    -(series.positions[0][0] + 11.5 * series.spacing[1])
}

/// Asserts that a mesh ends, towards the first column, in the middle between padding and samples.
fn assert_ends_at_padding(series: &Series, (vertices, _): &(Vec<Position>, Vec<Triangle>)) {
    let most = vertices.iter().map(|v| f64::from(v[0])).fold(f64::NEG_INFINITY, f64::max);
    let edge = edge_of_padding(series);
    assert!((most - edge).abs() < 1e-4, "it ends at {most}, not {edge}");
}

#[test]
fn padding_that_is_outside_by_its_own_value_changes_nothing_where_slopes_differ() {
    let series = Series::axial(5);
    let plain = mesh(padded(&series, 3, |_| false).path(), 500.0);
    assert_eq!(mesh(padded(&series, 3, |_| true).path(), 500.0), plain);
    assert_eq!(mesh(padded(&series, 3, |k| k != 2).path(), 500.0), plain);
}

#[test]
fn padding_that_is_inside_by_its_own_value_is_outside_where_slopes_differ() {
    let series = Series::axial(5);
    assert_ends_at_padding(&series, &mesh(padded(&series, 6000, |_| true).path(), 500.0));
}

#[test]
fn padding_of_floats_is_outside() {
    let series = Series::axial(5);
    let cols = usize::from(series.cols);
    // Value and limit of padding and pixels, with their VRs, of four bytes and of eight.
    let single = ((0x0122, 0x0124, *b"FL"), (0x0008, *b"OF"));
    let double = ((0x0123, 0x0125, *b"FD"), (0x0009, *b"OD"));
    for (size, (padding, pixels)) in [(4, single), (8, double)] {
        let folder = TempDir::new().unwrap();
        let bytes = |v: f64| match size {
            4 => (v as f32).to_le_bytes().to_vec(),
            _ => v.to_le_bytes().to_vec(),
        };
        series.write_as(folder.path(), EXPLICIT, |_, data| {
            let real = words(data).into_iter().map(|w| f64::from(w) * 0.25 - 100.0);
            let pad = |(at, v): (usize, f64)| match at % cols {
                0..6 => 3000.1,
                6..12 => 2900.5,
                _ => v,
            };
            let values: Vec<u8> = real.enumerate().map(pad).flat_map(bytes).collect();
            for tag in [PIXELS, BITS_STORED, HIGH_BIT, SIGN, RESCALED[0], RESCALED[1]] {
                data.remove(tag);
            }
            data.set((0x0028, 0x0100), *b"US", &(size * 8_u16).to_le_bytes());
            data.set((0x0028, padding.0), padding.2, &bytes(3000.1));
            data.set((0x0028, padding.1), padding.2, &bytes(2900.5));
            data.set((0x7FE0, pixels.0), pixels.1, &values);
        });
        assert_ends_at_padding(&series, &mesh(folder.path(), 500.0));
    }
}
