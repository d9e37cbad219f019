//! What is said of a mesh as a surface, against formulas.

use mcubes::mesh::{Defects, Mesh, Topology};

pub(crate) const CUBE: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3], // z = 0
    [4, 5, 6],
    [5, 7, 6], // z = 1
    [0, 1, 4],
    [1, 5, 4], // y = 0
    [2, 6, 3],
    [3, 6, 7], // y = 1
    [0, 4, 2],
    [2, 4, 6], // x = 0
    [1, 3, 5],
    [3, 7, 5], // x = 1
];

/// A cube of side 1 at `at`; corner c has bit 0 = +x, bit 1 = +y, bit 2 = +z.
pub(crate) fn corners(at: [f32; 3]) -> Vec<[f32; 3]> {
    (0..8_u8).map(|c| [0, 1, 2].map(|axis| at[axis as usize] + f32::from(c >> axis & 1))).collect()
}

fn cube(at: [f32; 3]) -> Mesh {
    Mesh { vertices: corners(at), normals: Vec::new(), triangles: CUBE.to_vec() }
}

/// Cubes with their vertices at equal points made one.
fn cubes(places: &[[f32; 3]]) -> Mesh {
    let mut mesh = Mesh::default();
    for &at in places {
        let cube = cube(at);
        for triangle in cube.triangles {
            let ids = triangle.map(|id| {
                let point = cube.vertices[id as usize];
                let found = mesh.vertices.iter().position(|&v| v == point);
                found.unwrap_or_else(|| {
                    mesh.vertices.push(point);
                    mesh.vertices.len() - 1
                }) as u32
            });
            mesh.triangles.push(ids);
        }
    }
    mesh
}

pub(crate) fn sound(
    mesh: &Mesh,
    n_components: u64,
    euler: i64,
    area: f64,
    volume: f64,
) -> Topology {
    let seen = mesh.topology();
    assert_eq!(seen.defects, Defects::default());
    assert!(seen.is_sound(), "{seen:?}");
    assert_eq!((seen.n_components, seen.euler), (n_components, euler));
    assert!((seen.area - area).abs() < 1e-9 * area, "{seen:?}");
    assert!((seen.volume - volume).abs() < 1e-9 * volume, "{seen:?}");
    seen
}

#[test]
fn a_cube_is_sound_with_the_area_and_volume_of_a_cube() {
    let seen = sound(&cube([0.0; 3]), 1, 2, 6.0, 1.0);
    assert_eq!((seen.n_vertices, seen.n_triangles), (8, 12));
    sound(&cubes(&[[0.0; 3], [3.0, 0.0, 0.0]]), 2, 4, 12.0, 2.0);
}

#[test]
fn a_small_part_far_from_the_origin_keeps_its_volume() {
    sound(&cube([-8_000_000.0, 8_000_000.0, 8_000_000.0]), 1, 2, 6.0, 1.0);
}

#[test]
fn a_torus_has_euler_number_zero_and_its_fans_hold_many_faces() {
    let (m, n) = (40_u32, 24_u32);
    let mut mesh = Mesh::default();
    for i in 0..m {
        for j in 0..n {
            let (u, v) = (f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
            let (u, v) = (u * std::f64::consts::TAU, v * std::f64::consts::TAU);
            let r = 3.0 + v.cos();
            mesh.vertices.push([r * u.cos(), r * u.sin(), v.sin()].map(|x| x as f32));
            let id = |i: u32, j: u32| (i % m) * n + j % n;
            mesh.triangles.push([id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
            mesh.triangles.push([id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
        }
    }
    let seen = mesh.topology();
    assert!(seen.is_sound());
    assert_eq!((seen.euler, seen.n_components), (0, 1));
    let exact = std::f64::consts::TAU * std::f64::consts::PI * 3.0;
    assert!((seen.volume / exact - 1.0).abs() < 0.02);

    // A double cone: its tips have fans of 200 faces.
    let n = 200;
    let mut cone = Mesh { vertices: vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], ..Mesh::default() };
    for i in 0..n {
        let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        cone.vertices.push([angle.cos() as f32, angle.sin() as f32, 0.0]);
        let (a, b) = (2 + i as u32, 2 + (i as u32 + 1) % n as u32);
        cone.triangles.push([0, a, b]);
        cone.triangles.push([1, b, a]);
    }
    let seen = cone.topology();
    assert!(seen.is_sound(), "{seen:?}");
    assert_eq!(seen.euler, 2);
}

#[test]
fn an_open_box_is_manifold_with_its_rim_as_boundary() {
    let mut mesh = cube([0.0; 3]);
    mesh.triangles.drain(2..4);
    let seen = mesh.topology();
    assert!(!seen.closed && seen.manifold && !seen.outward && !seen.is_sound());
    assert_eq!(seen.defects, Defects { boundary_edges: 4, ..Defects::default() });
    assert_eq!(seen.euler, 1);
    assert_eq!(seen.area, 5.0);
}

#[test]
fn cubes_that_share_an_edge_share_one_nonmanifold_edge() {
    let seen = cubes(&[[0.0; 3], [1.0, 1.0, 0.0]]).topology();
    assert!(seen.closed && !seen.manifold && !seen.is_sound());
    let expected = Defects { nonmanifold_edges: 1, nonmanifold_vertices: 2, ..Defects::default() };
    assert_eq!(seen.defects, expected);
    assert_eq!(seen.n_components, 1);
    assert!((seen.volume - 2.0).abs() < 1e-12);
}

#[test]
fn cubes_that_share_a_vertex_have_two_fans_there() {
    let seen = cubes(&[[0.0; 3], [1.0; 3]]).topology();
    assert!(seen.closed && !seen.manifold);
    assert_eq!(seen.defects, Defects { nonmanifold_vertices: 1, ..Defects::default() });
    assert_eq!((seen.n_components, seen.euler), (1, 3));
}

#[test]
fn a_flipped_face_disagrees_along_its_three_edges() {
    let mut mesh = cube([0.0; 3]);
    mesh.triangles[7].swap(0, 1);
    let seen = mesh.topology();
    assert!(seen.closed && seen.manifold && !seen.outward);
    assert_eq!(seen.defects, Defects { inconsistent_edges: 3, ..Defects::default() });
}

#[test]
fn a_mesh_turned_inside_out_is_not_outward() {
    let mut mesh = cube([5.0; 3]);
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    let seen = mesh.topology();
    assert_eq!(seen.defects, Defects::default());
    assert!(seen.closed && seen.manifold && !seen.outward && !seen.is_sound());
    assert!((seen.volume + 1.0).abs() < 1e-12);
}

#[test]
fn a_cavity_keeps_a_mesh_outward() {
    let mut mesh = cube([1.0; 3]);
    let outer = cube([0.0; 3]);
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh.triangles.extend(outer.triangles.iter().map(|t| t.map(|id| id + 8)));
    mesh.vertices.extend(outer.vertices.iter().map(|v| v.map(|x| x * 3.0)));
    sound(&mesh, 2, 4, 60.0, 26.0);
}

#[test]
fn a_moebius_strip_has_one_boundary_and_cannot_agree_in_winding() {
    let n = 9_u32;
    let mut mesh = Mesh::default();
    for i in 0..n {
        let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        for side in [-0.5, 0.5] {
            let r = 2.0 + side * (angle / 2.0).cos();
            let point = [r * angle.cos(), r * angle.sin(), side * (angle / 2.0).sin()];
            mesh.vertices.push(point.map(|x| x as f32));
        }
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < n { (a + 2, a + 3) } else { (1, 0) };
        mesh.triangles.push([a, c, b]);
        mesh.triangles.push([b, c, d]);
    }
    let seen = mesh.topology();
    assert_eq!(seen.euler, 0);
    assert!(seen.manifold && !seen.closed && !seen.outward);
    let expected =
        Defects { boundary_edges: 2 * u64::from(n), inconsistent_edges: 1, ..Defects::default() };
    assert_eq!(seen.defects, expected);
}

#[test]
fn degenerate_duplicate_coincident_unused_and_infinite_are_counted() {
    let mut mesh = cube([0.0; 3]);
    mesh.triangles.push([3, 3, 1]);
    let seen = mesh.topology();
    assert_eq!(seen.defects, Defects { zero_area_faces: 1, ..Defects::default() });
    assert!(seen.closed && seen.manifold && seen.outward && !seen.is_sound());

    let mut mesh = cube([0.0; 3]);
    mesh.triangles.push([2, 1, 0]);
    let seen = mesh.topology();
    assert_eq!(seen.defects.duplicate_faces, 1);
    assert_eq!(seen.defects.nonmanifold_edges, 3);

    let mut mesh = cube([0.0; 3]);
    mesh.vertices.push([-0.0, 0.0, 1.0]);
    mesh.vertices.push([f32::INFINITY, f32::NAN, 1.0]);
    let seen = mesh.topology();
    let expected = Defects {
        coincident_vertices: 1,
        unused_vertices: 2,
        nonfinite_vertices: 1,
        ..Defects::default()
    };
    assert_eq!(seen.defects, expected);
    assert_eq!(seen.euler, 2);

    // Three points on one line that is no axis.
    let line = Mesh {
        vertices: vec![[0.1, 0.2, 0.3], [0.2, 0.4, 0.6], [0.4, 0.8, 1.2]],
        normals: Vec::new(),
        triangles: vec![[0, 1, 2]],
    };
    assert_eq!(line.topology().defects.zero_area_faces, 1);

    let nothing = Mesh::default().topology();
    assert!(!nothing.closed && !nothing.manifold && !nothing.outward && !nothing.is_sound());
}
