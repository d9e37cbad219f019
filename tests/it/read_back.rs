//! What we write, as other readers and our own see it: the same bits, ids and normals.

use std::fs;

use mcubes::mesh::{Mesh, Patch};
use mcubes::sink::{Encoded, MeshFile, MeshFormat, MeshOptions, Sink};

use crate::writers::{names, tetrahedron, written};

/// The mesh that patches are.
fn whole(patches: &[Patch]) -> Mesh {
    Mesh {
        vertices: patches.iter().flat_map(|p| p.own_vertices().to_vec()).collect(),
        normals: patches.iter().flat_map(|p| p.normals.clone()).collect(),
        triangles: patches.iter().flat_map(|p| p.triangles.clone()).collect(),
    }
}

/// Every way to write, by its last parts: ascii, normals.
fn ways(format: MeshFormat) -> Vec<MeshOptions> {
    [(false, false), (false, true), (true, false), (true, true)]
        .map(|(ascii, normals)| MeshOptions { ascii, normals, ..MeshOptions::new(format) })
        .to_vec()
}

fn bits(points: &[[f32; 3]]) -> Vec<[u32; 3]> {
    points.iter().map(|p| p.map(f32::to_bits)).collect()
}

#[test]
fn a_ply_header_counts_and_has_one_length_for_all_counts() {
    let mut lengths = Vec::new();
    for n in [0, 1, 12] {
        let patch = Patch {
            vertices: vec![[0.0; 3]; n],
            triangles: vec![[0, 0, 0]; 3 * n],
            ..Patch::default()
        };
        let bytes = written(MeshOptions::new(MeshFormat::Ply), &[patch]);
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let lines: Vec<&str> = header.lines().map(str::trim_end).collect();
        let counts = [format!("element vertex {n}"), format!("element face {}", 3 * n)];
        let expected = [
            "ply",
            "format binary_little_endian 1.0",
            "comment mcubes",
            "comment SPACE=RAS",
            &counts[0],
            "property float x",
            "property float y",
            "property float z",
            &counts[1],
            "property list uchar int vertex_indices",
            "end_header",
        ];
        assert_eq!(lines, expected);
        assert_eq!(bytes.len(), end + n * 12 + 3 * n * 13);
        lengths.push(end);
    }
    lengths.dedup();
    assert_eq!(lengths.len(), 1);
}

#[test]
fn ply_rs_reads_back_the_same_bits_ids_and_normals() {
    let mesh = whole(&tetrahedron());
    for options in ways(MeshFormat::Ply) {
        let bytes = written(options, &tetrahedron());
        let parser = ply_rs::parser::Parser::<ply_rs::ply::DefaultElement>::new();
        let ply = parser.read_ply(&mut bytes.as_slice()).unwrap();
        let floats = |names: [&str; 3]| -> Vec<[f32; 3]> {
            let vertices = ply.payload["vertex"].iter();
            vertices.map(|v| names.map(|name| v[name].to_f32_lossy().unwrap())).collect()
        };
        assert_eq!(bits(&floats(["x", "y", "z"])), bits(&mesh.vertices), "{options:?}");
        if options.normals {
            assert_eq!(floats(["nx", "ny", "nz"]), mesh.normals);
        } else {
            assert!(!ply.header.elements["vertex"].properties.contains_key("nx"));
        }
        let faces = ply.payload["face"].iter();
        let faces: Vec<_> = faces.map(|f| f["vertex_indices"].to_u32_list().unwrap()).collect();
        assert_eq!(faces, mesh.triangles.iter().map(|t| t.to_vec()).collect::<Vec<_>>());
    }
}

#[test]
fn tobj_reads_back_the_same_bits_ids_and_normals() {
    let mesh = whole(&tetrahedron());
    for options in ways(MeshFormat::Obj) {
        let bytes = written(options, &tetrahedron());
        let (models, _) =
            tobj::load_obj_buf(&mut bytes.as_slice(), &tobj::LoadOptions::default(), |_| {
                Err(tobj::LoadError::GenericFailure)
            })
            .unwrap();
        assert_eq!(models.len(), 1);
        let read = &models[0].mesh;
        // It numbers vertices in the order of their use.
        let points = |points: &[f32], ids: &[u32]| -> Vec<[u32; 3]> {
            let point = |&id: &u32| [0, 1, 2].map(|x| points[3 * id as usize + x].to_bits());
            ids.iter().map(point).collect()
        };
        let own = |points: &[[f32; 3]]| -> Vec<[u32; 3]> {
            let ids = mesh.triangles.as_flattened().iter();
            ids.map(|&id| points[id as usize].map(f32::to_bits)).collect()
        };
        assert_eq!(read.positions.len(), 3 * mesh.vertices.len());
        assert_eq!(points(&read.positions, &read.indices), own(&mesh.vertices));
        if options.normals {
            assert_eq!(points(&read.normals, &read.normal_indices), own(&mesh.normals));
        } else {
            assert!(read.normals.is_empty());
        }
    }
}

#[test]
fn stl_io_reads_back_text_as_it_reads_back_binary() {
    let read = |ascii| {
        let options = MeshOptions { ascii, ..MeshOptions::new(MeshFormat::Stl) };
        let bytes = written(options, &tetrahedron());
        stl_io::read_stl(&mut std::io::Cursor::new(bytes)).unwrap()
    };
    let (binary, text) = (read(false), read(true));
    assert_eq!(binary.vertices, text.vertices);
    assert_eq!(binary.faces.len(), 4);
    for (a, b) in binary.faces.iter().zip(&text.faces) {
        assert_eq!((a.vertices, a.normal), (b.vertices, b.normal));
    }
}

#[test]
fn pieces_of_a_patch_make_the_same_file_as_the_patch() {
    for format in MeshFormat::ALL {
        for options in ways(format) {
            let at_once = written(options, &tetrahedron());
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("mesh");
            let mut file = MeshFile::create(&path, &options).unwrap();
            let encoder = file.encoder();
            for patch in tetrahedron() {
                let n = patch.triangles.len();
                for part in [0..n.min(1), n.min(1)..n] {
                    if part.start == 0 || !part.is_empty() {
                        let mut encoded = Encoded::default();
                        encoder.encode(&patch, part, &mut encoded);
                        file.append(&encoded).unwrap();
                    }
                }
            }
            file.finish(4, 4).unwrap();
            file.commit().unwrap();
            assert_eq!(fs::read(&path).unwrap(), at_once, "{options:?}");
        }
    }
}

#[test]
fn faces_beyond_what_memory_holds_wait_on_disk_and_follow() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.ply");
    let mut file = MeshFile::create(&path, &MeshOptions::new(MeshFormat::Ply)).unwrap();
    let encoder = file.encoder();
    let mut patch = Patch {
        vertices: vec![[0.5, 0.25, 0.125]; 3],
        triangles: vec![[0, 1, 2]; 1_100_000],
        ..Patch::default()
    };
    for _ in 0..5 {
        let mut encoded = Encoded::default();
        encoder.encode(&patch, 0..patch.triangles.len(), &mut encoded);
        file.append(&encoded).unwrap();
        patch.first_id += 3;
        patch.triangles.iter_mut().for_each(|t| *t = t.map(|id| id + 3));
    }
    file.finish(15, 5_500_000).unwrap();
    file.commit().unwrap();
    let mut expected = Vec::new();
    for id in 0..5_i32 {
        let ids = [3 * id, 3 * id + 1, 3 * id + 2];
        let mut face = vec![3];
        face.extend(ids.iter().flat_map(|id| id.to_le_bytes()));
        expected.push(face);
    }
    let bytes = fs::read(&path).unwrap();
    let body = &bytes[bytes.len() - 5_500_000 * 13..];
    for (face, bytes) in body.chunks(13).enumerate() {
        assert_eq!(bytes, expected[face / 1_100_000]);
    }
    assert_eq!(names(folder.path()), ["mesh.ply"]);
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(64))]

    #[test]
    fn every_finite_float_reads_back_as_itself_from_every_format(
        patterns in proptest::collection::vec(proptest::array::uniform3(0_u32..), 3..40)
    ) {
        let finite = |bits| Some(f32::from_bits(bits)).filter(|x| x.is_finite()).unwrap_or(0.1);
        let vertices: Vec<_> = patterns.iter().map(|p| p.map(finite)).collect();
        let last = vertices.len() as u32 - 1;
        let triangles = (2..=last).map(|c| [0, c - 1, c]).collect();
        let patch = Patch { vertices, triangles, ..Patch::default() };
        let mesh = whole(std::slice::from_ref(&patch));
        let corners = |mesh: &Mesh| -> Vec<[u32; 3]> {
            let ids = mesh.triangles.as_flattened().iter();
            // Adding zero turns −0 to 0: joined, they are one point.
            ids.map(|&id| mesh.vertices[id as usize].map(|x| (x + 0.0).to_bits())).collect()
        };
        for format in MeshFormat::ALL {
            for ascii in [false, true] {
                let options = MeshOptions { ascii, ..MeshOptions::new(format) };
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join("mesh");
                fs::write(&path, written(options, std::slice::from_ref(&patch))).unwrap();
                let read = mcubes::reader::read(&path).unwrap();
                proptest::prop_assert_eq!(corners(&read), corners(&mesh));
                if format != MeshFormat::Stl {
                    proptest::prop_assert_eq!(bits(&read.vertices), bits(&mesh.vertices));
                    proptest::prop_assert_eq!(&read.triangles, &mesh.triangles);
                }
            }
        }
    }
}
