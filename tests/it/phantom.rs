//! Phantoms: their surfaces are what the formulas say, and the files hold the volumes.

use std::path::Path;

use mcubes::cancel::Cancel;
use mcubes::geom::{Place, Space};
use mcubes::phantom::{Phantom, Shape};
use mcubes::pipeline::{Report, RunOptions, SurfaceOptions, extract};
use mcubes::sink::{MeshFile, MeshFormat, MeshOptions};
use mcubes::source::{OpenOptions, open};
use mcubes::volume::StoredType;

use crate::wrap::sources::{read, same};

fn report(phantom: &Phantom) -> Report {
    let folder = tempfile::tempdir().unwrap();
    let options = MeshOptions::new(MeshFormat::Stl);
    let mut file = MeshFile::create(&folder.path().join("p.stl"), &options).unwrap();
    let volume = phantom.volume().unwrap();
    let place = Place::new(&volume.meta.grid, Space::Ras).unwrap();
    let surfaces: Vec<(_, &mut dyn mcubes::sink::Sink)> =
        vec![(SurfaceOptions::at(phantom.shape.iso()), &mut file)];
    extract(volume, &place, surfaces, &RunOptions::default()).unwrap().remove(0)
}

#[test]
fn meshes_of_phantoms_have_the_area_volume_and_euler_number_of_the_formulas() {
    for shape in [Shape::Sphere, Shape::Ellipsoid, Shape::Torus] {
        for stored in [StoredType::F32, StoredType::U16, StoredType::I8] {
            let phantom = Phantom {
                dims: [70, 80, 50],
                spacing_mm: [0.5, 0.7, 0.9],
                stored,
                ..Phantom::new(shape)
            };
            let (truth, found) = (phantom.truth(), report(&phantom));
            let off = |a: f64, b: Option<f64>| (a / b.unwrap() - 1.0).abs();
            let (area, volume) = (found.measure.area, found.measure.volume);
            assert!(off(area, truth.area_mm2) < 5e-3, "{shape} {stored}: {area} {truth:?}");
            assert!(off(volume, truth.volume_mm3) < 5e-3, "{shape} {stored}: {volume} {truth:?}");
            let euler = found.n_vertices as i64 - found.n_triangles as i64 / 2;
            assert_eq!(Some(euler), truth.euler, "{shape} {stored}");
        }
    }
}

#[test]
fn shapes_without_a_formula_have_a_surface_and_no_numbers() {
    for shape in [Shape::Metaballs, Shape::Skull] {
        let phantom = Phantom { dims: [40; 3], ..Phantom::new(shape) };
        assert!(report(&phantom).n_triangles > 1000, "{shape}");
        assert_eq!(phantom.truth(), mcubes::phantom::Truth::default());
    }
}

#[test]
fn half_of_the_box_of_a_gyroid_is_inside() {
    let phantom = Phantom {
        dims: [61, 50, 43],
        spacing_mm: [0.5, 0.7, 0.9],
        stored: StoredType::F32,
        ..Phantom::new(Shape::Gyroid)
    };
    let (truth, found) = (phantom.truth(), report(&phantom));
    assert_eq!((truth.area_mm2, truth.euler), (None, None));
    let off = found.measure.volume / truth.volume_mm3.unwrap() - 1.0;
    assert!(off.abs() < 5e-3, "{off}");
}

fn assert_written(phantom: &Phantom, path: &Path) {
    phantom.write(Some(path), 3, &Cancel::new()).unwrap();
    let written = open(path, &OpenOptions::default(), &Cancel::new()).unwrap();
    let made = phantom.volume().unwrap();
    assert_eq!(written.meta.stored, phantom.stored);
    assert_eq!(written.meta.rescale, made.meta.rescale);
    assert_eq!(written.meta.grid, made.meta.grid);
    assert!(same(&read(written), &read(made)), "{phantom:?}");
}

#[test]
fn a_file_holds_the_volume_whatever_its_type() {
    let folder = tempfile::tempdir().unwrap();
    for (n, stored) in StoredType::ALL.into_iter().enumerate() {
        // Numbers that single precision has, since NIfTI-1 holds the affine in it.
        let phantom = Phantom {
            dims: [9, 8, 7],
            spacing_mm: [0.5, 0.75, 2.0],
            noise: 37.0,
            seed: n as u64,
            stored,
            ..Phantom::new(if n % 2 == 0 { Shape::Skull } else { Shape::Sphere })
        };
        assert_written(&phantom, &folder.path().join(format!("{stored}.nii")));
        assert_written(&phantom, &folder.path().join(format!("{stored}.nii.gz")));
    }
    let left: Vec<_> = folder.path().read_dir().unwrap().collect();
    assert_eq!(left.len(), 20, "{left:?}");
}

#[test]
fn threads_change_nothing_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let phantom = Phantom { dims: [9, 8, 17], noise: 5.0, ..Phantom::new(Shape::Torus) };
    for end in ["nii", "nii.gz"] {
        let bytes = [1, 2, 5, 64].map(|threads| {
            let path = folder.path().join(format!("{threads}.{end}"));
            phantom.write(Some(&path), threads, &Cancel::new()).unwrap();
            std::fs::read(path).unwrap()
        });
        assert!(bytes.iter().all(|b| *b == bytes[0]), "{end}");
    }
}

#[test]
fn an_axis_beyond_the_first_version_of_nifti_is_written_in_the_second() {
    let folder = tempfile::tempdir().unwrap();
    let phantom = Phantom { dims: [3, 40_000, 2], ..Phantom::new(Shape::Gyroid) };
    let path = folder.path().join("long.nii");
    assert_written(&phantom, &path);
    assert_eq!(std::fs::read(path).unwrap()[..4], 540_i32.to_le_bytes());
}

#[test]
fn noise_is_the_seeds_and_has_the_deviation_asked_for() {
    let with = |noise: f64, seed: u64| {
        let stored = StoredType::F64;
        let phantom = Phantom { dims: [24; 3], noise, seed, stored, ..Phantom::new(Shape::Skull) };
        read(phantom.volume().unwrap())
    };
    let clean = with(0.0, 0);
    let noise = with(20.0, 1) - &clean;
    assert!((noise.std(0.0) - 20.0).abs() < 0.5 && noise.mean().unwrap().abs() < 0.5);
    assert!(same(&with(20.0, 1), &with(20.0, 1)) && !same(&with(20.0, 1), &with(20.0, 2)));
}

#[test]
fn what_cannot_be_made_is_refused_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.nii.gz");
    let good = Phantom { dims: [4; 3], ..Phantom::new(Shape::Sphere) };
    let refused = |phantom: Phantom| {
        phantom.write(Some(&path), 2, &Cancel::new()).unwrap_err().kind().as_str()
    };
    assert_eq!(refused(Phantom { dims: [4, 0, 4], ..good }), "bad-dims");
    assert_eq!(refused(Phantom { spacing_mm: [1.0, -1.0, 1.0], ..good }), "bad-affine");
    assert_eq!(refused(Phantom { spacing_mm: [1.0, f64::NAN, 1.0], ..good }), "bad-affine");
    assert_eq!(refused(Phantom { spacing_mm: [1.0, 1e-42, 1.0], ..good }), "bad-affine");
    assert_eq!(refused(Phantom { spacing_mm: [1.0, 1.0, 1e38], ..good }), "bad-affine");
    assert_eq!(refused(Phantom { noise: f64::INFINITY, ..good }), "bad-config");
    let stopped = Cancel::new();
    stopped.raise();
    assert_eq!(good.write(Some(&path), 2, &stopped).unwrap_err().kind().as_str(), "interrupted");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    // One sample along an axis is a volume too.
    for shape in Shape::ALL {
        read(Phantom { dims: [1, 5, 1], ..Phantom::new(shape) }.volume().unwrap());
    }
}
