//! What only a program can ask of the library, since the command lets no such number through.

use mcubes::error::{Failure, Kind};
use mcubes::geom::{Affine, Dims, Grid, Place, PlaceError, Space};
use mcubes::pipeline::{RunError, RunOptions, SurfaceOptions, extract};
use mcubes::sink::{Format, MeshFile, MeshOptions, Sink};
use mcubes::source::formula;
use ndarray::Array3;

const NO_NUMBERS: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// A slope with infinities and NaN: samples that no iso value may meet.
fn volume() -> Array3<f32> {
    let mut volume = Array3::from_shape_fn((4, 5, 6), |(z, y, x)| (x + y + z) as f32);
    for (n, value) in NO_NUMBERS.into_iter().enumerate() {
        volume[(1, 2, n)] = value as f32;
    }
    volume
}

fn dims() -> Dims {
    Dims::checked(6, 5, 4, 4).unwrap()
}

#[test]
fn a_mesh_at_an_iso_value_that_is_no_number_is_refused() {
    let (volume, grid) = (volume(), Grid::new(dims(), Affine::IDENTITY));
    for iso in NO_NUMBERS {
        let (surface, run) = (SurfaceOptions::at(iso), RunOptions::default());
        let in_voxels = mcubes::mesh(volume.view(), &surface, &run);
        let placed = mcubes::mesh_placed(volume.view(), &grid, Space::Ras, &surface, &run);
        for refused in [in_voxels, placed] {
            let error = refused.err().unwrap();
            assert_eq!(error.to_string(), RunError::Iso(iso).to_string());
            assert_eq!(error.kind(), Kind::IsoNotReached);
        }
    }
}

#[test]
fn a_run_with_one_iso_value_that_is_no_number_writes_no_surface() {
    let folder = tempfile::tempdir().unwrap();
    for iso in NO_NUMBERS {
        let volume = formula(dims(), Affine::IDENTITY, |x, _, _| x as f32).unwrap();
        let place = Place::new(&volume.meta.grid, Space::Ras).unwrap();
        let stl = MeshOptions::new(Format::Stl);
        let mut files = ["a.stl", "b.stl"]
            .map(|name| MeshFile::create(&folder.path().join(name), &stl).unwrap());
        let sinks = files.iter_mut().map(|file| file as &mut dyn Sink);
        let surfaces = [2.5, iso].map(SurfaceOptions::at).into_iter().zip(sinks).collect();
        let error = extract(volume, &place, surfaces, &RunOptions::default()).unwrap_err();
        assert!(
            matches!(error, RunError::Iso(found) if found.to_bits() == iso.to_bits()),
            "{error}"
        );
        assert_eq!(error.kind(), Kind::IsoNotReached);
        assert!(files.map(|file| file.commit().is_err()).into_iter().all(|failed| failed));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_place_that_is_no_number_is_refused() {
    let volume = volume();
    let (surface, run) = (SurfaceOptions::at(4.5), RunOptions::default());
    for nowhere in NO_NUMBERS {
        for at in 0..12 {
            let mut rows = *Affine::IDENTITY.rows();
            rows[at / 4][at % 4] = nowhere;
            let even = Grid::new(dims(), Affine::from_rows(rows));
            let mut origins: Vec<_> = (0..4).map(|k| [0.0, 0.0, f64::from(k * k)]).collect();
            origins[at / 3][at % 3] = nowhere;
            let uneven = Grid::uneven(dims(), Affine::IDENTITY, origins);
            for grid in [even, uneven] {
                for space in [Space::Ras, Space::Lps] {
                    let placed = mcubes::mesh_placed(volume.view(), &grid, space, &surface, &run);
                    let error = placed.err().unwrap();
                    assert_eq!(error.to_string(), PlaceError::NotFinite.to_string(), "{grid:?}");
                    assert_eq!(error.kind(), Kind::OutOfRangeSpace);
                }
                // There it does not matter where the volume is.
                mcubes::mesh_placed(volume.view(), &grid, Space::Voxel, &surface, &run).unwrap();
            }
        }
    }
}
