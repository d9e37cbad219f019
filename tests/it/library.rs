//! What only a program can ask of the library, since the command lets no such number through.

use mcubes::error::{Failure, Kind};
use mcubes::geom::{Affine, Dims, Grid, Place, PlaceError, Space};
use mcubes::pipeline::{RunError, RunOptions, SurfaceOptions, extract};
use mcubes::sink::{MeshFile, MeshFormat, MeshOptions, Sink};
use mcubes::source::{AnyPlanes, Planes, Volume, formula};
use mcubes::volume::SourceFormat;
use mcubes::volume::{Meta, StoredType};
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
        let stl = MeshOptions::new(MeshFormat::Stl);
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

/// What became of a volume of 6 x 5 x 4 samples that was placed in `space`, written to a PLY.
fn written(
    planes: Planes<'_, f32>,
    place: &Place,
    mesh: &MeshOptions,
) -> Result<Vec<[f32; 3]>, RunError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let meta =
        Meta::plain(SourceFormat::Memory, Grid::new(dims(), Affine::IDENTITY), StoredType::F32);
    let volume = Volume { meta, planes: AnyPlanes::F32(planes) };
    let mut file = MeshFile::create(&path, mesh)?;
    let surfaces: Vec<(_, &mut dyn Sink)> = vec![(SurfaceOptions::at(4.5), &mut file)];
    extract(volume, place, surfaces, &RunOptions::default())?;
    file.commit()?;
    Ok(mcubes::reader::read(&path).unwrap().normals)
}

#[test]
fn what_is_of_another_size_than_its_volume_is_refused() {
    let mesh = MeshOptions::new(MeshFormat::Ply);
    let other = |nx, ny, nz| Grid::new(Dims::checked(nx, ny, nz, 4).unwrap(), Affine::IDENTITY);
    let right = Place::new(&other(6, 5, 4), Space::Ras).unwrap();
    for [nx, ny, nz] in [[3, 3, 3], [6, 5, 8], [9, 9, 4], [4, 5, 6], [1, 1, 1]] {
        let array = Array3::<f32>::zeros((nz, ny, nx));
        let of_array = written(Planes::Resident(array.view()), &right, &mesh);
        let wrong = Place::new(&other(nx as i64, ny as i64, nz as i64), Space::Ras).unwrap();
        let of_place = written(Planes::Resident(volume().view()), &wrong, &mesh);
        for error in [of_array.unwrap_err(), of_place.unwrap_err()] {
            assert!(matches!(error, RunError::Grid { .. }), "{error}");
        }
        let mut grid = other(6, 5, 4);
        grid.plane_origins = Some((0..nx).map(|k| [0.0, 0.0, (k * k) as f64]).collect());
        let found = Place::new(&grid, Space::Ras).err();
        assert_eq!(found, (nx != 4).then_some(PlaceError::PlaneOrigins { found: nx, expected: 4 }));
    }
}

#[test]
fn planes_follow_each_other_along_one_direction() {
    let placed = |heights: [f64; 4]| {
        let mut grid = Grid::new(dims(), Affine::IDENTITY);
        grid.plane_origins = Some(heights.map(|z| [0.0, 0.0, z]).to_vec());
        Place::new(&grid, Space::Ras).err()
    };
    assert_eq!(placed([0.0, 1.0, 2.5, 3.0]), None);
    assert_eq!(placed([3.0, 2.5, 1.0, 0.0]), None);
    assert_eq!(placed([0.0, 2.0, 1.0, 3.0]), Some(PlaceError::PlaneOrder(1)));
    assert_eq!(placed([3.0, 1.0, 0.0, 0.5]), Some(PlaceError::PlaneOrder(2)));
}

#[test]
fn a_file_says_no_other_space_than_its_volume_is_placed_in() {
    let all = [Space::Ras, Space::Lps, Space::Voxel];
    for placed in all {
        let place = Place::new(&Grid::new(dims(), Affine::IDENTITY), placed).unwrap();
        for space in all {
            let mesh = MeshOptions { space, ..MeshOptions::new(MeshFormat::Ply) };
            let done = written(Planes::Resident(volume().view()), &place, &mesh);
            assert_eq!(done.is_ok(), space == placed);
        }
    }
}

#[test]
fn a_file_with_normals_gets_them() {
    let place = Place::new(&Grid::new(dims(), Affine::IDENTITY), Space::Ras).unwrap();
    let mesh = MeshOptions { normals: true, ..MeshOptions::new(MeshFormat::Ply) };
    let normals = written(Planes::Resident(volume().view()), &place, &mesh).unwrap();
    assert!(!normals.is_empty());
    for n in normals {
        assert!((n.iter().map(|x| x * x).sum::<f32>().sqrt() - 1.0).abs() < 1e-5, "{n:?}");
    }
}
