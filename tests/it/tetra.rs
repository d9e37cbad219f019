//! Marching tetrahedra: the tables by exhaustion, and the same promise as of cubes.

use std::collections::{BTreeSet, HashSet};

use mcubes::geom::{Affine, Dims, Grid, Space};
use mcubes::kernel::{Cpu, Method, N_TETRA_EDGES, Rule, TetraTables, edge_ends};
use mcubes::pipeline::{RunOptions, SurfaceOptions};
use mcubes::volume::Side;
use ndarray::Array3;
use proptest::prelude::*;

use crate::support::manifold::{assert_clean, enclosed};
use crate::support::oracle::Enclosed;
use crate::support::random::Random;
use crate::surface::{check, crossings, mesh, mesh_by, mesh_on, volume, wild_f32};

fn at(iso: f64) -> SurfaceOptions {
    SurfaceOptions { method: Method::Tetrahedra, ..SurfaceOptions::at(iso) }
}

fn triangles(case: u8) -> Vec<[usize; 3]> {
    let tables = TetraTables::get(false);
    let n = 3 * usize::from(tables.n_triangles[usize::from(case)]);
    let ids = &tables.ids[usize::from(case)].as_flattened()[..n];
    ids.chunks(3).map(|t| [t[0], t[1], t[2]].map(usize::from)).collect()
}

fn is_crossed(case: u8, edge: usize) -> bool {
    let [a, b] = edge_ends(edge);
    (case >> a ^ case >> b) & 1 == 1
}

#[test]
fn edges_are_the_nineteen_edges_of_the_split() {
    let edges: BTreeSet<[usize; 2]> = (0..N_TETRA_EDGES).map(edge_ends).collect();
    let expected: BTreeSet<[usize; 2]> = (0..8)
        .flat_map(|a| (0..8).map(move |b| [a, b]))
        .filter(|[a, b]| a < b && a & b == *a)
        .collect();
    assert_eq!(edges, expected);
    for edge in 0..12 {
        assert_eq!(edge_ends(edge), mcubes::kernel::cube::edge_corners(edge));
    }
}

#[test]
fn every_case_uses_its_crossed_edges_and_ends_in_its_faces() {
    for case in 0..=255 {
        let found = triangles(case);
        assert!(found.len() <= 12);
        let used: BTreeSet<usize> = found.concat().into_iter().collect();
        let crossed: BTreeSet<usize> =
            (0..N_TETRA_EDGES).filter(|&l| is_crossed(case, l)).collect();
        assert_eq!(used, crossed);
        let sides: Vec<[usize; 2]> =
            found.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let once: BTreeSet<[usize; 2]> = sides.iter().copied().collect();
        assert_eq!(once.len(), sides.len());
        for [a, b] in sides {
            let corners = [edge_ends(a), edge_ends(b)].concat();
            let in_face = (0..3).any(|axis| {
                let bits: BTreeSet<usize> = corners.iter().map(|c| c >> axis & 1).collect();
                bits.len() == 1
            });
            assert_eq!(once.contains(&[b, a]), !in_face, "case {case}: {a} -> {b}");
        }
    }
}

#[test]
fn ids_move_on_with_their_right_hand_edge() {
    let tables = TetraTables::get(false);
    for case in 0..=255u8 {
        for edge in 0..N_TETRA_EDGES {
            let [a, b] = edge_ends(edge);
            // An edge in the cell's left face is the cell before's; that on the right is counted.
            let is_shared = (a ^ b) & 1 == 0;
            let [a, b] = if is_shared { [a | 1, b | 1] } else { [a, b] };
            let expected = (case >> a ^ case >> b) & 1;
            assert_eq!(tables.crossed[usize::from(case)][edge], expected, "{case} {edge}");
        }
    }
}

#[test]
fn all_pairs_of_cells_are_closed_manifold_and_outward() {
    for bits in 1..4096u32 {
        let values: Vec<f32> = (0..12).map(|i| f32::from((bits >> i & 1) as u8) - 0.5).collect();
        for dims in [(2, 2, 3), (2, 3, 2), (3, 2, 2)] {
            let volume = Array3::from_shape_vec(dims, values.clone()).unwrap();
            let (vertices, triangles) = mesh(volume.view(), &at(0.0));
            assert_clean(&vertices, &triangles, &format!("{bits:#x} {dims:?}"));
            assert!(enclosed(&vertices, &triangles) > 0.0);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn noise_is_closed_manifold_and_outward(v in volume(wild_f32())) {
        check(&v, Method::Tetrahedra, |x| x >= 0.0);
    }

    #[test]
    fn plateaus_at_the_iso_value_are_closed_manifold_and_outward(v in volume(-1i16..=1)) {
        check(&v, Method::Tetrahedra, |x| x >= 0);
    }

    #[test]
    fn any_slabs_threads_and_instructions_give_the_same_bytes(
        v in volume(-2i16..=2), slab in 1..5usize, open: bool
    ) {
        let surface = SurfaceOptions { open, ..at(0.5) };
        let expected = mesh(v.view(), &surface);
        for threads in [1, 2, 7] {
            prop_assert_eq!(&mesh_by(v.view(), &surface, threads, Some(slab)), &expected);
        }
        let rule = Rule { iso: 0.5, side: Side::AtLeast, method: Method::Tetrahedra, open };
        for cpu in [Cpu::Scalar, Cpu::Sse2, Cpu::Avx2, Cpu::Avx512] {
            prop_assert_eq!(&mesh_on(v.view(), rule, cpu), &expected, "{:?}", cpu);
        }
    }

    #[test]
    fn there_is_one_vertex_for_each_edge_of_the_split_whose_ends_differ(v in volume(-3i16..=3)) {
        let (vertices, _) = mesh(v.view(), &at(0.25));
        let edges: Vec<[i64; 3]> = (1..8).map(|step| [step & 1, step >> 1 & 1, step >> 2]).collect();
        let found: HashSet<[u32; 3]> =
            vertices.iter().map(|v| v.map(|x| (x + 0.0).to_bits())).collect();
        prop_assert_eq!(found.len(), vertices.len());
        prop_assert_eq!(found, crossings(&v, 0.25, &edges));
    }

    /// So that a triangle's corners are what they were numbered as.
    #[test]
    fn every_triangle_lies_in_one_tetrahedron_of_the_split(v in volume(-3i16..=3)) {
        let (vertices, triangles) = mesh(v.view(), &at(0.25));
        for t in triangles {
            let points = t.map(|id| vertices[id as usize]);
            let low = [0, 1, 2].map(|axis| {
                points.iter().map(|p| p[axis]).fold(f32::INFINITY, f32::min).floor()
            });
            // In a tetrahedron the coordinates have one order, and stay within the cell. Less than a
            // rounding of 512 in `f32`.
            let within = points.map(|p| [0, 1, 2].map(|axis| p[axis] - low[axis]));
            prop_assert!(within.as_flattened().iter().all(|x| (0.0..=1.0).contains(x)));
            let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
            let falls = |[a, b, c]: [usize; 3]| {
                within.iter().all(|p| p[a] >= p[b] - 1e-4 && p[b] >= p[c] - 1e-4)
            };
            prop_assert!(orders.into_iter().any(falls), "{:?}", points);
        }
    }
}

#[test]
fn a_mirrored_map_turns_the_triangles_round() {
    let mut random = Random::new(21);
    let volume = Array3::from_shape_simple_fn((5, 6, 7), || random.between(-1.0, 1.0));
    let dims = Dims::checked(7, 6, 5, 8).unwrap();
    let mut rows = *Affine::IDENTITY.rows();
    rows[0][0] = -1.0;
    let grid = Grid::new(dims, Affine::from_rows(rows));
    let options = RunOptions::default();
    let surface =
        mcubes::pipeline::mesh_placed(volume.view(), &grid, Space::Ras, &at(0.0), &options)
            .unwrap();
    assert_clean(&surface.vertices, &surface.triangles, "mirrored");
    assert!(enclosed(&surface.vertices, &surface.triangles) > 0.0);
}

/// What is inside is, for its topology, the samples inside with the edges, triangles and
/// tetrahedra of the split that lie between them.
#[test]
fn the_euler_number_is_that_of_the_split_between_inside_samples() {
    let mut random = Random::new(22);
    for _ in 0..500 {
        let n = 4;
        let values: Vec<f64> = (0..n * n * n).map(|_| random.between(-1.0, 1.0)).collect();
        let inside =
            |p: [usize; 3]| p.iter().all(|&x| x < n) && values[p[0] + n * (p[1] + n * p[2])] >= 0.0;
        // Chains of corners, each on from the one before: simplices of the split, counted once at
        // their lowest corner.
        let chains: Vec<Vec<usize>> = (0..128u32)
            .map(|set| (1..8).filter(|c| set >> (c - 1) & 1 == 1).collect::<Vec<usize>>())
            .filter(|chain| chain.windows(2).all(|w| w[0] & w[1] == w[0]))
            .collect();
        assert_eq!(chains.len(), 26, "1, 7 edges, 12 triangles, 6 tetrahedra");
        let mut euler = 0i64;
        for i in 0..n * n * n {
            let low = [i % n, i / n % n, i / n / n];
            for chain in &chains {
                let at = |c: usize| [low[0] + (c & 1), low[1] + (c >> 1 & 1), low[2] + (c >> 2)];
                if inside(low) && chain.iter().all(|&c| inside(at(c))) {
                    euler += if chain.len() % 2 == 0 { 1 } else { -1 };
                }
            }
        }
        let volume = Array3::from_shape_vec((n, n, n), values.clone()).unwrap();
        let (vertices, triangles) = mesh(volume.view(), &at(0.0));
        assert_eq!(Enclosed::of(&vertices, &triangles).euler, 2 * euler);
    }
}
