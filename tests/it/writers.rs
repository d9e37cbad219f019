//! What mesh files hold, and that they appear whole or not at all.

use std::fs;
use std::path::Path;

use mcubes::Kind;
use mcubes::error::Failure;
use mcubes::geom::Space;
use mcubes::mesh::Patch;
use mcubes::sink::{Encoded, MeshFile, MeshFormat, MeshOptions, Sink, SinkError};

/// A tetrahedron in two patches with an empty one between; the last repeats the vertices of the
/// first as ghosts.
pub(crate) fn tetrahedron() -> Vec<Patch> {
    let vertices =
        [[0.1, -0.0, 1e-7], [1.5, 0.0, 0.0], [0.0, 16_777_216.0, 0.3], [-1.25, 0.0, 7.0]];
    let normals = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8]];
    vec![
        Patch {
            first_id: 0,
            n_ghosts: 0,
            vertices: vertices[..3].to_vec(),
            normals: normals[..3].to_vec(),
            triangles: vec![[0, 2, 1]],
        },
        Patch::default(),
        Patch {
            first_id: 0,
            n_ghosts: 3,
            vertices: vertices.to_vec(),
            normals: normals[3..].to_vec(),
            triangles: vec![[0, 1, 3], [1, 2, 3], [2, 0, 3]],
        },
    ]
}

pub(crate) fn write(file: &mut MeshFile, patches: &[Patch]) {
    let encoder = file.encoder();
    let mut encoded = Encoded::default();
    let (mut n_vertices, mut n_triangles) = (0, 0);
    for patch in patches {
        encoded.vertices.clear();
        encoded.faces.clear();
        encoder.encode(patch, 0..patch.triangles.len(), &mut encoded);
        file.append(&encoded).unwrap();
        n_vertices += patch.own_vertices().len() as u64;
        n_triangles += patch.triangles.len() as u64;
    }
    file.finish(n_vertices, n_triangles).unwrap();
}

pub(crate) fn written(options: MeshOptions, patches: &[Patch]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh");
    let mut file = MeshFile::create(&path, &options).unwrap();
    write(&mut file, patches);
    file.commit().unwrap();
    assert_eq!(names(folder.path()), ["mesh"]);
    fs::read(&path).unwrap()
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn the_format_is_known_by_extension_and_by_name_in_any_case() {
    assert_eq!(MeshFormat::from_path(Path::new("a.b/skull.STL")), Some(MeshFormat::Stl));
    assert_eq!(MeshFormat::from_path(Path::new("skull.ply")), Some(MeshFormat::Ply));
    assert_eq!(MeshFormat::from_path(Path::new("skull.stl.Obj")), Some(MeshFormat::Obj));
    assert_eq!(MeshFormat::from_path(Path::new("stl")), None);
    assert_eq!(MeshFormat::from_path(Path::new("skull.vtk")), None);
    assert_eq!(MeshFormat::from_name("Ply"), Some(MeshFormat::Ply));
}

#[test]
fn a_binary_stl_has_eighty_bytes_of_header_a_count_and_fifty_bytes_a_triangle() {
    let patches = tetrahedron();
    let bytes = written(MeshOptions::new(MeshFormat::Stl), &patches);
    assert_eq!(bytes.len(), 84 + 4 * 50);
    assert_eq!(&bytes[..80], format!("{:<80}", "mcubes SPACE=RAS").as_bytes());
    assert_eq!(bytes[80..84], 4_u32.to_le_bytes());

    let mesh = stl_io::read_stl(&mut std::io::Cursor::new(&bytes)).unwrap();
    assert_eq!(mesh.faces.len(), 4);
    let triangles = patches.iter().flat_map(|p| p.triangles.iter().map(|&t| p.corners(t)));
    for (face, corners) in mesh.faces.iter().zip(triangles) {
        for (id, corner) in face.vertices.iter().zip(corners) {
            assert_eq!(mesh.vertices[*id].0.map(f32::to_bits), corner.map(f32::to_bits));
        }
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let (u, v): ([f64; 3], [f64; 3]) =
            (std::array::from_fn(|x| b[x] - a[x]), std::array::from_fn(|x| c[x] - a[x]));
        let n: [f64; 3] = std::array::from_fn(|x| {
            u[(x + 1) % 3] * v[(x + 2) % 3] - u[(x + 2) % 3] * v[(x + 1) % 3]
        });
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        for x in 0..3 {
            assert!((f64::from(face.normal.0[x]) - n[x] / length).abs() < 1e-7);
        }
    }
}

#[test]
fn the_space_is_named_as_slicer_reads_it_and_voxel_files_name_none() {
    for format in MeshFormat::ALL {
        for ascii in [false, true] {
            for (space, tag) in [
                (Space::Ras, Some("SPACE=RAS")),
                (Space::Lps, Some("SPACE=LPS")),
                (Space::Voxel, None),
            ] {
                let options = MeshOptions { ascii, space, ..MeshOptions::new(format) };
                let bytes = written(options, &tetrahedron());
                let text = String::from_utf8_lossy(&bytes);
                match tag {
                    Some(tag) => assert_eq!(text.matches(tag).count(), 1, "{options:?}"),
                    None => {
                        assert!(!text.contains("RAS") && !text.contains("LPS"), "{options:?}");
                    }
                }
                assert_eq!(text.starts_with("solid"), format == MeshFormat::Stl && ascii);
            }
        }
    }
}

#[test]
fn a_file_that_is_not_committed_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for format in MeshFormat::ALL {
        let path = folder.path().join("mesh");
        let mut file = MeshFile::create(&path, &MeshOptions::new(format)).unwrap();
        assert!(!path.exists());
        write(&mut file, &tetrahedron());
        assert!(!path.exists(), "it has its name only when it is committed");
        drop(file);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}

#[test]
fn an_existing_file_is_replaced_at_the_end_and_kept_until_then() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.stl");
    fs::write(&path, "before").unwrap();
    let options = MeshOptions::new(MeshFormat::Stl);
    let mut file = MeshFile::create(&path, &options).unwrap();
    write(&mut file, &tetrahedron());
    assert_eq!(fs::read(&path).unwrap(), b"before");
    file.commit().unwrap();
    assert_eq!(fs::read(&path).unwrap().len(), 284);
    assert_eq!(names(folder.path()), ["mesh.stl"]);
}

#[test]
fn an_unfinished_file_cannot_be_committed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.stl");
    let file = MeshFile::create(&path, &MeshOptions::new(MeshFormat::Stl)).unwrap();
    assert_eq!(file.commit().unwrap_err().kind(), Kind::Internal);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn totals_that_do_not_match_what_was_appended_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.stl");
    let mut file = MeshFile::create(&path, &MeshOptions::new(MeshFormat::Stl)).unwrap();
    assert_eq!(file.finish(3, 1).unwrap_err().kind(), Kind::Internal);
    let too_many = file.finish(3, 1 << 32).unwrap_err();
    assert_eq!(too_many.kind(), Kind::TooManyTriangles);
    assert_eq!(
        too_many.to_string(),
        "the mesh has 4294967296 triangles, the format can count 4294967295"
    );
}

#[test]
fn a_missing_folder_and_a_folder_in_place_of_a_file_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let options = MeshOptions::new(MeshFormat::Ply);
    let missing = folder.path().join("none");
    let error = MeshFile::create(&missing.join("mesh.ply"), &options).err().unwrap();
    assert!(matches!(&error, SinkError::NoFolder(found) if *found == missing));
    assert_eq!(error.kind(), Kind::Unwritable);
    let error = MeshFile::create(folder.path(), &options).err().unwrap();
    assert!(matches!(error, SinkError::IsFolder));
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn a_mesh_has_the_permissions_of_any_new_file() {
        let folder = tempfile::tempdir().unwrap();
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        let path = folder.path().join("mesh.stl");
        let mut file = MeshFile::create(&path, &MeshOptions::new(MeshFormat::Stl)).unwrap();
        write(&mut file, &tetrahedron());
        file.commit().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain));
    }

    #[test]
    fn a_symbolic_link_stays_and_the_file_it_points_to_is_made_or_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("other");
        fs::create_dir(&other).unwrap();
        let link = folder.path().join("link.stl");
        symlink("other/mesh.stl", &link).unwrap();
        for _ in ["made", "replaced"] {
            let mut file = MeshFile::create(&link, &MeshOptions::new(MeshFormat::Stl)).unwrap();
            write(&mut file, &tetrahedron());
            file.commit().unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(names(&other), ["mesh.stl"]);
            assert_eq!(fs::read(&link).unwrap().len(), 284);
        }
        let ring = folder.path().join("ring.stl");
        symlink("ring.stl", &ring).unwrap();
        let error = MeshFile::create(&ring, &MeshOptions::new(MeshFormat::Stl)).err().unwrap();
        assert_eq!(error.kind(), Kind::Unwritable);
    }

    #[test]
    fn a_device_is_written_to_and_a_full_one_is_reported() {
        let null = Path::new("/dev/null");
        let mut file = MeshFile::create(null, &MeshOptions::new(MeshFormat::Ply)).unwrap();
        write(&mut file, &tetrahedron());
        file.commit().unwrap();
        assert!(!fs::metadata(null).unwrap().is_file());

        let full = Path::new("/dev/full");
        if full.exists() {
            let mut file = MeshFile::create(full, &MeshOptions::new(MeshFormat::Obj)).unwrap();
            write(&mut file, &tetrahedron());
            let error = file.commit().unwrap_err();
            assert_eq!(error.kind(), Kind::Unwritable);
            assert_eq!(
                error.hint().as_deref(),
                Some("the disk is full; make room or write elsewhere")
            );
        }
    }
}

#[cfg(unix)]
#[test]
fn who_may_read_a_file_may_read_what_replaces_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.stl");
    let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
    for wanted in [0o600, 0o444, 0o666] {
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(wanted)).unwrap();
        let mut file = MeshFile::create(&path, &MeshOptions::new(MeshFormat::Stl)).unwrap();
        write(&mut file, &tetrahedron());
        file.commit().unwrap();
        assert_eq!(mode(), wanted, "{:o}", mode());
        fs::remove_file(&path).unwrap();
    }
}
