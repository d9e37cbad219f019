//! Mesh files read back for `check`.

use std::fs;
use std::path::PathBuf;

use mcubes::Kind;
use mcubes::reader;

use crate::topology::{CUBE, corners, sound};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn fails(&self, name: &str, bytes: impl AsRef<[u8]>, kind: Kind, message: &str) {
        let path = self.file(name, bytes);
        let error = reader::read(&path).unwrap_err();
        assert_eq!(error.kind(), kind, "{error}");
        assert_eq!(error.to_string(), format!("{}: {message}", path.display()));
    }
}

const STL_FACET: &str =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

#[test]
fn stl_corners_at_one_point_become_one_vertex_and_zero_has_no_sign() {
    let folder = Folder::new();
    let mut bytes = vec![b' '; 80];
    bytes[..5].copy_from_slice(b"solid");
    bytes.extend(12_u32.to_le_bytes());
    for triangle in CUBE {
        bytes.extend([0; 12]);
        for (place, id) in triangle.into_iter().enumerate() {
            let mut point = corners([0.0; 3])[id as usize];
            if place == 1 {
                point = point.map(|x| if x == 0.0 { -0.0 } else { x });
            }
            bytes.extend(point.iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    let mesh = reader::read(&folder.file("cube.stl", &bytes)).unwrap();
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12));
    sound(&mesh, 1, 2, 6.0, 1.0);
    // Under another name too: content decides.
    assert_eq!(reader::read(&folder.file("cube.ply", &bytes)).unwrap(), mesh);

    bytes[..5].copy_from_slice(b"other");
    folder.fails(
        "cut.stl",
        &bytes[..683],
        Kind::TruncatedData,
        "the header counts 12 triangles, which take 684 bytes; there are 683",
    );
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    folder.fails(
        "claim.stl",
        &bytes,
        Kind::TruncatedData,
        "the header counts 4294967295 triangles, which take 214748364834 bytes; there are 684",
    );
}

#[test]
fn a_text_stl_is_read_and_one_cut_short_is_refused() {
    let folder = Folder::new();
    let whole = format!("solid a b c\r\n{STL_FACET}{}endsolid\n", STL_FACET.to_uppercase());
    let mesh = reader::read(&folder.file("a.stl", &whole)).unwrap();
    assert_eq!(mesh.vertices, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2]]);

    let cut = |word| 12 + STL_FACET.find(word).unwrap();
    for (end, within) in [
        (cut("endfacet"), "a facet"),
        (cut("vertex 0 1") + 8, "line 6"),
        (12 + STL_FACET.len(), "a solid"),
    ] {
        let text = format!("solid a b c\n{STL_FACET}");
        folder.fails(
            "cut.stl",
            &text[..end],
            Kind::TruncatedData,
            &format!("the data end within {within}"),
        );
    }
    folder.fails(
        "words.stl",
        "solid\nfacet\nouter loop\nvertex 1 2 three\n",
        Kind::BadHeader,
        "line 4: expected vertex x y z, found 'vertex 1 2 three'",
    );
}

#[test]
fn obj_ids_count_from_one_or_backwards_and_polygons_become_fans() {
    let folder = Folder::new();
    let text = "# a\no x\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n\
                f 1/1/1 2//1 3/1 4\nf -4 -2 -1\n";
    let mesh = reader::read(&folder.file("a.obj", text)).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    assert_eq!(mesh.vertices.len(), 4);
    assert!(mesh.normals.is_empty());

    let fails = |text: &str, message: &str| folder.fails("b.obj", text, Kind::BadHeader, message);
    fails("v 0 0 0\nf 1 2 3\n", "face 1 names vertex 3, there are 1");
    fails("v 0 0 0\nf 0 1 1\n", "face 1 names vertex 0, there are 1");
    fails("v 0 0 0\nf -2 1 1\n", "face 1 names vertex -2, there are 1");
    fails("v 0 0 0\nf 1 1\n", "face 1 has 2 corners, expected 3 or more");
    fails("v 0 0\n#\n", "line 1: expected v x y z, found 'v 0 0'");
    fails("v 0 0 0\nf 1 a 1\n", "line 2: expected vertex numbers after f, found 'f 1 a 1'");
    let far = "face 1 names vertex 9223372036854775807, there are 1";
    fails("v 0 0 0\nf 1 1 9223372036854775807\n", far);
}

#[test]
fn ply_of_every_encoding_and_type_gives_the_same_mesh() {
    let folder = Folder::new();
    let head = |format: &str, real: &str, list: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment x\nelement vertex 4\nproperty {real} x\n\
             property {real} y\nproperty uchar red\nproperty {real} z\nelement face 2\n\
             property list {list} vertex_index\nproperty float q\nelement edge 1\n\
             property int a\nend_header\n"
        )
    };
    let points = [[0.5_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, -2.0], [0.0, 1.0, 0.25]];
    let faces = [vec![0_u16, 1, 2, 3], vec![3, 2, 0]];

    let mut text = head("ascii", "float", "uchar int").into_bytes();
    for [x, y, z] in points {
        text.extend(format!("{x} {y} 7 {z}\n").bytes());
    }
    text.extend(b"\n4 0 1 2 3 1.5\r\n3  3 2 0 2\n9");
    let mut big = head("binary_big_endian", "double", "ushort ushort").into_bytes();
    let mut little = head("binary_little_endian", "float", "int uint").into_bytes();
    for [x, y, z] in points {
        big.extend([x, y].iter().flat_map(|&x| f64::from(x).to_be_bytes()));
        big.push(7);
        big.extend(f64::from(z).to_be_bytes());
        little.extend([x, y].iter().flat_map(|x| x.to_le_bytes()));
        little.push(7);
        little.extend(z.to_le_bytes());
    }
    for face in &faces {
        big.extend((face.len() as u16).to_be_bytes());
        big.extend(face.iter().flat_map(|id| id.to_be_bytes()));
        big.extend([0; 4]);
        little.extend((face.len() as i32).to_le_bytes());
        little.extend(face.iter().flat_map(|&id| u32::from(id).to_le_bytes()));
        little.extend([0; 4]);
    }
    big.extend([0; 4]);
    little.extend([0; 4]);
    for bytes in [&text, &big, &little] {
        let mesh = reader::read(&folder.file("a.ply", bytes)).unwrap();
        assert_eq!(mesh.vertices, points);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [3, 2, 0]]);
        // Cut anywhere, it is refused and never a panic.
        for end in 0..bytes.len() {
            let path = folder.file("cut.ply", &bytes[..end]);
            let error = reader::read(&path).unwrap_err();
            let kinds = [Kind::TruncatedData, Kind::BadHeader, Kind::UnknownFormat];
            assert!(kinds.contains(&error.kind()), "{end}: {error}");
        }
    }
}

#[test]
fn a_ply_that_claims_what_is_not_there_is_refused_before_it_is_read() {
    let folder = Folder::new();
    let head = |n: &str, m: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {n}\nproperty float x\n\
             property float y\nproperty float z\nelement face {m}\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    };
    let mut huge = head("3", "18446744073709551615").into_bytes();
    huge.extend([0; 36]);
    let wanted = huge.len() as u128 + u128::from(u64::MAX);
    folder.fails(
        "huge.ply",
        &huge,
        Kind::TruncatedData,
        &format!(
            "the header counts 18446744073709551615 elements face, which take {wanted} bytes; \
             there are {}",
            huge.len()
        ),
    );
    let id = |id: i32| {
        let mut bytes = head("1", "1").into_bytes();
        bytes.extend([0; 12]);
        bytes.push(3);
        bytes.extend([0, 0, id].iter().flat_map(|id| id.to_le_bytes()));
        bytes
    };
    folder.fails("id.ply", id(1), Kind::BadHeader, "face 1 names vertex 1, there are 1");
    folder.fails("id.ply", id(-1), Kind::BadHeader, "face 1 names vertex -1, there are 1");
    let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                  property float z\nend_header\n0 0 0\n";
    folder.fails("points.ply", points, Kind::BadHeader, "there is no element face");
    let words = points.replace("element vertex 1", "elephant vertex");
    folder.fails(
        "words.ply",
        words,
        Kind::BadHeader,
        "the PLY header cannot be read: line 3: couldn't parse line",
    );
}

#[test]
fn what_is_no_mesh_is_said_so() {
    let folder = Folder::new();
    let unknown = "is no mesh file: neither STL nor PLY nor OBJ";
    for (name, bytes) in [
        ("a", ""),
        ("a.stl", ""),
        ("a.txt", "hello\n"),
        ("a.obj", "# only this\n"),
        ("a.bin", "\0\0"),
    ] {
        folder.fails(name, bytes, Kind::UnknownFormat, unknown);
    }
    folder.fails("b.stl", "\0", Kind::TruncatedData, "the data end within the header");
    let error = reader::read(folder.0.path()).unwrap_err();
    assert_eq!(error.kind(), Kind::Unreadable);
    let error = reader::read(&folder.0.path().join("none.stl")).unwrap_err();
    assert_eq!(error.kind(), Kind::NotFound);
}

#[test]
fn a_line_of_an_obj_may_go_on_behind_a_backslash() {
    let folder = Folder::new();
    let plain = "# a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let broken = "# a\\\nv 0 \\\n0 0\nv 1 0 0\r\nv 0 1 0\nf 1 \\\r\n2\\\n 3\n";
    let [plain, broken] = [("a.obj", plain), ("b.obj", broken)]
        .map(|(name, text)| reader::read(&folder.file(name, text)).unwrap());
    assert_eq!((plain.vertices, plain.triangles), (broken.vertices, broken.triangles));
    let end = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\nx\n";
    folder.fails(
        "c.obj",
        end,
        Kind::BadHeader,
        "line 5: expected vertex numbers after f, found 'f 1 2  x'",
    );
}

#[test]
fn a_byte_order_mark_is_no_part_of_text_and_words_of_stl_may_be_large() {
    let folder = Folder::new();
    let solid = format!("solid a\n{STL_FACET}endsolid a\n");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let plain = reader::read(&folder.file("a.stl", &solid)).unwrap();
    for (name, text) in [
        ("a.stl", solid.to_uppercase()),
        ("a.stl", format!("\u{feff}{solid}")),
        ("a", format!("\u{feff}{}", solid.to_uppercase())),
        ("a.ply", format!("\u{feff}{ply}")),
        ("a.obj", format!("\u{feff}{obj}")),
        ("a", format!("\u{feff}{obj}")),
    ] {
        let mesh = reader::read(&folder.file(name, &text)).unwrap();
        assert_eq!(
            (&mesh.vertices, &mesh.triangles),
            (&plain.vertices, &plain.triangles),
            "{text}"
        );
    }
}
