//! DICOM written by the tests: an ellipsoid of known place and volume comes out at that place,
//! unsheared, with that volume, however the slices lie.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::path::Path;

use mcubes::error::Kind;
use mcubes::geom::Space;
use mcubes::geom::vec3::Vec3;
use mcubes::mesh::{Position, Triangle};
use mcubes::pipeline::{RunOptions, SurfaceOptions, mesh_placed};
use mcubes::source::dicom::{self, OpenOptions, ScanOptions, Selector, Study};
use ndarray::Array3;
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{Ellipsoid, SECRET, Series};
use crate::support::manifold::{assert_clean, enclosed};
#[cfg(target_os = "linux")]
use crate::support::memory::peak_kib;

fn scan(folder: &Path) -> Study {
    dicom::scan(folder, &ScanOptions::default()).unwrap()
}

fn mesh(study: &Study, index: usize, options: OpenOptions) -> (Vec<Position>, Vec<Triangle>) {
    let volume = study.open(index, &options).unwrap();
    let grid = volume.meta.grid.clone();
    let [nx, ny, nz] = grid.dims.to_array();
    let values = Array3::from_shape_vec((nz, ny, nx), values(volume).unwrap()).unwrap();
    let (surface, run) = (SurfaceOptions::at(Ellipsoid::LEVEL), RunOptions::default());
    let mesh = mesh_placed(values.view(), &grid, Space::Lps, &surface, &run).unwrap();
    (mesh.vertices.to_vec(), mesh.triangles.to_vec())
}

/// Meshes a volume and compares the mesh with the ellipsoid; `reach` is the most that a vertex may
/// be off, in mm.
fn assert_ellipsoid(
    study: &Study,
    index: usize,
    options: OpenOptions,
    body: &Ellipsoid,
    reach: f64,
) {
    let (vertices, triangles) = mesh(study, index, options);
    assert_clean(&vertices, &triangles, "ellipsoid");
    let off = vertices.iter().map(|v| body.distance(v.map(f64::from)).abs()).fold(0.0, f64::max);
    assert!(off < reach, "a vertex is {off} mm from the ellipsoid");
    let part = enclosed(&vertices, &triangles) / body.volume();
    assert!((0.98..1.001).contains(&part), "it encloses {part} of the ellipsoid's volume");
    for axis in 0..3 {
        let least = vertices.iter().map(|v| f64::from(v[axis])).fold(f64::INFINITY, f64::min);
        let most = vertices.iter().map(|v| f64::from(v[axis])).fold(f64::NEG_INFINITY, f64::max);
        let middle = f64::midpoint(least, most);
        assert!((middle - body.centre[axis]).abs() < 0.1, "centre {middle} along axis {axis}");
        assert!((most - least - 2.0 * body.semi[axis]).abs() < 0.4, "size along axis {axis}");
    }
}

fn assert_series(series: &Series) {
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let study = scan(folder.path());
    assert_eq!(study.volumes.len(), 1);
    let index = study.default().unwrap();
    assert_ellipsoid(&study, index, OpenOptions::default(), &series.body, 0.1);
}

const X: Vec3 = [1.0, 0.0, 0.0];
const Y: Vec3 = [0.0, 1.0, 0.0];

#[test]
fn an_axial_series_gives_the_ellipsoid() {
    assert_series(&Series::axial(28));
}

#[test]
fn a_sagittal_series_gives_the_ellipsoid() {
    assert_series(&Series::through(Y, [0.0, 0.0, -1.0], [-1.5, 0.0, 0.0], 30));
}

#[test]
fn an_oblique_series_gives_the_ellipsoid() {
    // Two unit vectors at right angles, and their product.
    let (row, column) = ([2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0], [2.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0]);
    let normal = [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0].map(|v| v * 1.5);
    assert_series(&Series::through(row, column, normal, 30));
}

#[test]
fn a_tilted_gantry_gives_the_ellipsoid_unsheared() {
    let angle = 20.0_f64.to_radians();
    let column = [0.0, angle.cos(), -angle.sin()];
    let series = Series::through(X, column, [0.0, 0.0, 1.5], 36);
    assert_series(&series);
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let tilt = scan(folder.path()).volumes[0].series.tilt_degrees;
    assert!((tilt - 20.0).abs() < 1e-6, "{tilt}");
}

#[test]
fn a_missing_slice_is_refused_with_its_place_and_spanned_when_asked() {
    let mut series = Series::axial(28);
    series.positions.remove(13);
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let study = scan(folder.path());
    let index = study.default().unwrap();
    let error = study.open(index, &OpenOptions::default()).err().unwrap();
    assert_eq!(error.kind(), Kind::MissingSlices);
    let line = error.to_string();
    assert!(line.contains("1 slice is missing: 3.00 mm between"), "{line}");
    assert!(line.contains("the others are 1.50 mm apart"), "{line}");
    assert!(error.hint().unwrap().contains("--gaps span"));
    assert_ellipsoid(&study, index, OpenOptions { span_gaps: true }, &series.body, 0.2);
}

#[test]
fn a_missing_slice_is_refused_among_positions_that_are_written_rounded() {
    for step in [0.625, 1.25, 0.7] {
        let mut series = Series::through(X, Y, [0.0, 0.0, step], 24);
        for position in &mut series.positions {
            position[2] = (position[2] * 10.0).round() / 10.0;
        }
        let folder = TempDir::new().unwrap();
        series.write(folder.path());
        assert!(scan(folder.path()).open(0, &OpenOptions::default()).is_ok(), "{step}");
        series.positions.remove(11);
        let folder = TempDir::new().unwrap();
        series.write(folder.path());
        let error = scan(folder.path()).open(0, &OpenOptions::default()).err().unwrap();
        assert_eq!(error.kind(), Kind::MissingSlices, "{step}: {error}");
        assert!(error.to_string().contains("1 slice is missing"), "{step}: {error}");
    }
}

#[test]
fn uneven_slices_are_meshed_where_they_lie() {
    let mut series = Series::axial(28);
    // Thinner towards the top.
    let first = series.positions[0];
    for (k, position) in series.positions.iter_mut().enumerate() {
        let t = k as f64 / 27.0;
        position[2] = first[2] + 27.0 * 1.5 * (1.4 * t - 0.4 * t * t);
    }
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let study = scan(folder.path());
    let meta = study.volumes[0].meta.as_ref().unwrap();
    assert_eq!(meta.gaps_mm.as_ref().map(Vec::len), Some(27));
    assert!(!meta.notes.is_empty());
    assert_ellipsoid(&study, 0, OpenOptions::default(), &series.body, 0.2);
}

#[test]
fn of_two_series_the_larger_is_taken_and_the_other_can_be_chosen() {
    let large = Series { number: 7, ..Series::axial(28) };
    let mut small = Series::through(Y, [0.0, 0.0, -1.0], [-3.0, 0.0, 0.0], 14);
    (small.uid, small.number) = ("1.2.826.0.1.3680043.9.7.2".to_owned(), 3);
    let folder = TempDir::new().unwrap();
    large.write(&folder.path().join("a b/c"));
    small.write(&folder.path().join("d"));
    std::fs::write(folder.path().join("notes.txt"), "not a picture").unwrap();
    let study = scan(folder.path());
    let index = study.default().unwrap();
    assert_eq!(study.volumes[index].series.uid, large.uid);
    assert_ellipsoid(&study, index, OpenOptions::default(), &large.body, 0.1);
    // Numbers follow SeriesNumber.
    assert_eq!(study.choose(&Selector::Number(1)).unwrap(), 0);
    let by_uid = study.choose(&Selector::Uid(small.uid.clone())).unwrap();
    assert_eq!(study.volumes[by_uid].series.uid, small.uid);
    assert_ellipsoid(&study, by_uid, OpenOptions::default(), &small.body, 0.3);
    let said = study.choice(index).unwrap().to_string();
    assert!(said.contains("series 7") && said.contains("series 3"), "{said}");
    let none = study.choose(&Selector::Number(3)).unwrap_err();
    assert_eq!(none.kind(), Kind::NoSeries);
}

#[test]
fn nothing_that_is_reported_tells_who_the_patient_is() {
    let mut series = Series::axial(12);
    series.positions.remove(5);
    let folder = TempDir::new().unwrap();
    series.write(folder.path());
    let mut cut = series.image(3, 40);
    cut.truncate(cut.len() - 100);
    std::fs::write(folder.path().join("cut"), cut).unwrap();
    let study = scan(folder.path());
    let error = study.open(0, &OpenOptions::default()).err().unwrap();
    let said = format!("{:?} {:?} {:?} {error:?}", study.volumes, study.set_aside, study.faults);
    assert!(!said.contains(SECRET), "{said}");
}

#[test]
fn a_scan_tells_how_far_it_is_and_stops_when_asked() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let folder = TempDir::new().unwrap();
    Series::axial(9).write(folder.path());
    let seen = AtomicUsize::new(0);
    let progress = |n: usize| {
        seen.fetch_max(n, Ordering::Relaxed);
    };
    let options = ScanOptions { progress: Some(&progress), ..ScanOptions::default() };
    dicom::scan(folder.path(), &options).unwrap();
    assert_eq!(seen.load(Ordering::Relaxed), 9);
    let options = ScanOptions::default();
    options.cancel.raise();
    let error = dicom::scan(folder.path(), &options).err().unwrap();
    assert_eq!(error.kind(), Kind::Interrupted);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "writes 525 MB; tells how long listing and reading take, and how much memory"]
fn a_thousand_slices_are_listed_without_reading_their_pixels() {
    let folder = TempDir::new().unwrap();
    let series = Series { cols: 512, rows: 512, ..Series::axial(1000) };
    series.write(folder.path());
    let before = peak_kib();
    for _ in 0..3 {
        let start = std::time::Instant::now();
        let study = scan(folder.path());
        assert_eq!(study.volumes[0].dims, [512, 512, 1000]);
        eprintln!("scanned in {:?}, {} KiB more at the peak", start.elapsed(), peak_kib() - before);
        assert!(start.elapsed().as_secs() < 5);
    }
    let start = std::time::Instant::now();
    let volume = scan(folder.path()).open(0, &OpenOptions::default()).unwrap();
    let mcubes::source::AnyPlanes::U16(mcubes::source::Planes::Positioned(planes)) = volume.planes
    else {
        panic!("not u16")
    };
    let mut plane = ndarray::Array2::zeros((512, 512));
    for k in 0..1000 {
        planes.read_plane(k, plane.view_mut()).unwrap();
    }
    let more = peak_kib() - before;
    eprintln!("all read in {:?}, {more} KiB more at the peak", start.elapsed());
    assert!(more < 100 << 10, "{more} KiB for 525 MB of samples");
}
