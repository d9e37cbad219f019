//! Peak memory for STL is a few slabs, whatever the number of planes, and no more than a run is said
//! to take.

use std::io::Write;

use mcubes::cancel::Cancel;
use mcubes::geom::{Affine, Dims, Place, Space};
use mcubes::pipeline::{Method, RunOptions, SurfaceOptions, extract, working_bytes};
use mcubes::sink::{MeshFile, MeshFormat, MeshOptions, Sink};
use mcubes::source::{RawInput, RawOptions, Volume, formula, open_raw};
use mcubes::volume::StoredType;

use crate::support::memory::{is_alone, peak_kib};

/// Meshes a volume to STL in a file that goes away; how long it was.
fn mesh(volume: Volume<'_>, surface: SurfaceOptions, options: &RunOptions<'_>) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.stl");
    let place = Place::new(&volume.meta.grid, Space::Ras).unwrap();
    let mut file = MeshFile::create(&path, &MeshOptions::new(MeshFormat::Stl)).unwrap();
    let surfaces: Vec<(_, &mut dyn Sink)> = vec![(surface, &mut file)];
    extract(volume, &place, surfaces, options).unwrap();
    file.commit().unwrap();
    path.metadata().unwrap().len()
}

/// The same, and no more memory than the run is said to take.
fn mesh_within_bound(volume: Volume<'_>, surface: SurfaceOptions, threads: usize) -> (u64, u64) {
    let options = RunOptions { threads, ..RunOptions::default() };
    let (dims, sample) = (volume.meta.grid.dims, volume.meta.stored.size());
    let bound = working_bytes(dims, sample, surface.method, 1, 0, &options);
    let before = peak_kib();
    let written = mesh(volume, surface, &options);
    let taken = (peak_kib() - before) << 10;
    println!("{threads} threads: {taken} bytes taken, {bound} said, {written} written");
    assert!(taken <= bound, "{taken} bytes, at most {bound}");
    (written, bound)
}

/// A rod with waves on it.
fn rod(n_planes: i64, radius: f64) -> Volume<'static> {
    let dims = Dims::checked(256, 256, n_planes, 4).unwrap();
    let field = move |x: f64, y: f64, z: f64| {
        (radius + 4.0 * (z * 0.1).sin() - (x - 127.0).hypot(y - 127.0)) as f32
    };
    formula(dims, Affine::IDENTITY, field).unwrap()
}

fn long_rod(threads: usize, method: Method) {
    let volume = rod(2000, 50.0);
    let volume_bytes = volume.meta.grid.dims.n_samples() * 4;
    let surface = SurfaceOptions { method, ..SurfaceOptions::at(0.0) };
    let (written, bound) = mesh_within_bound(volume, surface, threads);
    // Had either been held, the bound would have told.
    assert!(volume_bytes > bound && written > bound, "{volume_bytes} {written} {bound}");
}

#[test]
fn a_long_volume_takes_no_more_than_it_is_said_to() {
    if is_alone("memory::a_long_volume_takes_no_more_than_it_is_said_to") {
        long_rod(2, Method::Cubes);
    }
}

#[test]
fn a_long_volume_of_tetrahedra_takes_no_more_than_it_is_said_to() {
    if is_alone("memory::a_long_volume_of_tetrahedra_takes_no_more_than_it_is_said_to") {
        long_rod(2, Method::Tetrahedra);
    }
}

#[test]
fn eight_times_the_planes_take_no_more_memory() {
    if !is_alone("memory::eight_times_the_planes_take_no_more_memory") {
        return;
    }
    // One thread, so that the two runs have as many slabs under way.
    let options = RunOptions { threads: 1, ..RunOptions::default() };
    let taken = |n_planes| {
        let written = mesh(rod(n_planes, 50.0), SurfaceOptions::at(0.0), &options);
        (peak_kib(), written)
    };
    let ((short, few), (long, many)) = (taken(250), taken(2000));
    assert!(many > 7 * few, "{few} and {many} bytes written");
    // A plane's own entry in a list is a few words.
    println!("{short} KiB, then {long}");
    assert!(long - short <= 512, "{} KiB more", long - short);
}

/// Planes of one sample a row, whose bits take sixty times what the samples do.
fn narrow(threads: usize, method: Method) {
    let dims = [1, 100_000, 64];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("narrow.raw");
    let mut file = std::fs::File::create(&path).unwrap();
    for k in 0..dims[2] {
        let wave = |j: i64| 127.0 + 60.0 * ((j as f64 * 0.1).sin() + (k as f64 * 0.3).sin());
        let plane: Vec<u8> = (0..dims[1]).map(|j| wave(j) as u8).collect();
        file.write_all(&plane).unwrap();
    }
    let options = RawOptions::new(dims, StoredType::U8);
    let volume = open_raw(RawInput::Path(path), &options, &Cancel::new()).unwrap();
    let surface = SurfaceOptions { method, ..SurfaceOptions::at(240.5) };
    mesh_within_bound(volume, surface, threads);
}

#[test]
fn a_narrow_volume_takes_no_more_than_it_is_said_to() {
    if is_alone("memory::a_narrow_volume_takes_no_more_than_it_is_said_to") {
        narrow(2, Method::Cubes);
    }
}

#[test]
fn a_narrow_volume_on_one_thread_takes_no_more_than_it_is_said_to() {
    if is_alone("memory::a_narrow_volume_on_one_thread_takes_no_more_than_it_is_said_to") {
        narrow(1, Method::Cubes);
    }
}

#[test]
fn a_narrow_volume_of_tetrahedra_takes_no_more_than_it_is_said_to() {
    if is_alone("memory::a_narrow_volume_of_tetrahedra_takes_no_more_than_it_is_said_to") {
        narrow(2, Method::Tetrahedra);
    }
}

/// A block that is inside throughout: its first and last layer have millions of triangles.
fn block(threads: usize, method: Method) {
    let dims = Dims::checked(1500, 1500, 4, 4).unwrap();
    let volume = formula(dims, Affine::IDENTITY, |_, _, _| 1.0).unwrap();
    let surface = SurfaceOptions { method, ..SurfaceOptions::at(0.5) };
    mesh_within_bound(volume, surface, threads);
}

#[test]
fn wide_flat_caps_take_no_more_than_they_are_said_to() {
    if is_alone("memory::wide_flat_caps_take_no_more_than_they_are_said_to") {
        block(1, Method::Cubes);
    }
}

#[test]
fn wide_flat_caps_of_tetrahedra_take_no_more_than_they_are_said_to() {
    if is_alone("memory::wide_flat_caps_of_tetrahedra_take_no_more_than_they_are_said_to") {
        block(1, Method::Tetrahedra);
    }
}
