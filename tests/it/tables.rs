//! The tables of cases, by exhaustion.

use std::collections::{BTreeMap, BTreeSet};

use mcubes::kernel::cube::{edge_corners, face_corners, faces_of, is_ambiguous, is_crossed};
use mcubes::kernel::{Row, Tables};

fn triangles(row: &Row) -> Vec<[u8; 3]> {
    let n = 3 * usize::from(row.n_triangles);
    row.ids.as_flattened()[..n].chunks(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// The directed sides of triangles that have no partner.
fn border(triangles: &[[u8; 3]]) -> Vec<[u8; 2]> {
    let mut sides = BTreeSet::new();
    for &[a, b, c] in triangles {
        for side in [[a, b], [b, c], [c, a]] {
            assert!(side[0] != side[1] && sides.insert(side), "{side:?} twice in {triangles:?}");
        }
    }
    let alone = |&&[a, b]: &&[u8; 2]| !sides.contains(&[b, a]);
    sides.iter().filter(alone).copied().collect()
}

/// The face that holds two edges.
fn shared_face(a: u8, b: u8) -> Option<usize> {
    let both = faces_of(a.into()) & faces_of(b.into());
    (both != 0).then(|| both.trailing_zeros() as usize)
}

#[test]
fn half_of_the_cases_are_settled_by_their_corners() {
    let tables = Tables::get(false);
    let unsettled: Vec<usize> = (0..256).filter(|&case| tables.is_unsettled[case]).collect();
    assert_eq!(unsettled.len(), 128);
    let ambiguous = |case: usize| (0..6).any(|face| is_ambiguous(case as u8, face));
    assert_eq!(unsettled.iter().filter(|&&case| ambiguous(case)).count(), 120);
    for &case in unsettled.iter().filter(|&&case| !ambiguous(case)) {
        let few = if case.count_ones() == 2 { case } else { 255 - case };
        assert_eq!(few.trailing_zeros() + (7 - few.leading_zeros() % 8), 7, "opposite corners");
    }
    for case in 0..256 {
        let row = &tables.rows[usize::from(tables.first_row[case])];
        assert_eq!(row.n_centres + row.n_walls, 0);
        assert!(row.n_triangles <= 5);
        assert_eq!(tables.ids[case], row.ids[0]);
        let fast = if tables.is_unsettled[case] { 0 } else { row.n_triangles };
        assert_eq!(tables.n_triangles[case], fast);
    }
}

#[test]
fn ids_move_on_where_the_right_hand_edge_is_crossed() {
    let tables = Tables::get(false);
    for case in 0..=255u8 {
        let inside = |x: usize, y: usize, z: usize| case >> (x + 2 * y + 4 * z) & 1 == 1;
        let crossed = &tables.crossed[usize::from(case)];
        for n in 0..2 {
            for m in 0..2 {
                let x_edge = inside(0, n, m) != inside(1, n, m);
                let y_edge = inside(1, 0, n) != inside(1, 1, n);
                let z_edge = inside(1, n, 0) != inside(1, n, 1);
                assert_eq!(crossed[n + 2 * m], u8::from(x_edge));
                assert_eq!(crossed[4 + n + 2 * m], u8::from(y_edge));
                assert_eq!(crossed[8 + 2 * n + m], u8::from(z_edge));
            }
        }
        assert_eq!(crossed[12..], [0; 4]);
    }
}

/// Which rows a case has: those without a tunnel from its `first_row` on.
fn plain_rows(case: usize) -> std::ops::Range<usize> {
    let tables = Tables::get(false);
    let n = 1 << (0..6).filter(|&face| is_ambiguous(case as u8, face)).count();
    let first = usize::from(tables.first_row[case]);
    first..first + n
}

#[test]
fn every_row_is_a_surface_with_one_line_through_each_crossed_edge() {
    let tables = Tables::get(false);
    assert_eq!(tables.rows.len(), 816);
    assert_eq!((0..256).map(|case| plain_rows(case).len()).sum::<usize>(), 656);
    for (number, row) in tables.rows.iter().enumerate() {
        let triangles = triangles(row);
        assert!(triangles.len() <= 16 && row.n_walls <= 3 && row.n_centres <= 1);
        assert!(row.n_walls == 0 || row.n_centres == 0, "walls or a centre, never both");
        let border = border(&triangles);
        let mut ends = BTreeMap::new();
        for [a, b] in &border {
            assert!(*a < 12 && *b < 12 && shared_face(*a, *b).is_some(), "{number}: {border:?}");
            *ends.entry(a).or_insert([0; 2]).first_mut().unwrap() += 1;
            *ends.entry(b).or_insert([0; 2]).last_mut().unwrap() += 1;
        }
        assert!(ends.values().all(|&n| n == [1, 1]), "{number}");
        let mut vertices: BTreeSet<u8> = BTreeSet::new();
        let mut sides = BTreeSet::new();
        for &[a, b, c] in &triangles {
            vertices.extend([a, b, c]);
            sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
        }
        let in_face = |&&[a, b]: &&[u8; 2]| b < 12 && shared_face(a, b).is_some();
        assert_eq!(sides.iter().filter(in_face).count(), border.len(), "{number}: in a face");
        let extra = vertices.iter().filter(|&&v| v >= 12).count();
        assert_eq!(extra, usize::from(row.n_walls + row.n_centres));
        // As many disks as loops, or two loops fewer of them and an annulus.
        let euler = vertices.len() + triangles.len() - sides.len();
        let loops = n_loops(&border);
        assert_eq!(
            euler,
            if number < Tables::N_PLAIN_ROWS { loops } else { loops - 2 },
            "{number}"
        );
    }
}

fn n_loops(border: &[[u8; 2]]) -> usize {
    let next: BTreeMap<u8, u8> = border.iter().map(|&[a, b]| (a, b)).collect();
    let mut left: BTreeSet<u8> = next.keys().copied().collect();
    let mut n = 0;
    while let Some(start) = left.pop_first() {
        n += 1;
        let mut at = next[&start];
        while at != start {
            left.remove(&at);
            at = next[&at];
        }
    }
    n
}

/// A face's own numbering of its four edges, the same from both cells at it, is what the positions
/// of an edge's corners across the face's axis are.
fn in_face(edge: u8, face: usize) -> [usize; 2] {
    edge_corners(edge.into()).map(|corner| corner & !(1 << (face / 2)))
}

/// The directed lines on one face, each from edge to edge.
type Lines = Vec<[[usize; 2]; 2]>;

#[test]
fn cells_on_either_side_of_a_face_draw_the_same_lines() {
    let tables = Tables::get(false);
    let mut drawn: BTreeMap<(usize, u8), [BTreeSet<Lines>; 2]> = BTreeMap::new();
    for case in 0..256usize {
        for number in plain_rows(case) {
            let border = border(&triangles(&tables.rows[number]));
            for face in 0..6 {
                let (axis, side) = (face / 2, face & 1);
                let mut corners = face_corners(face);
                corners.sort_unstable();
                let bits = corners.iter().fold(0, |bits, c| bits << 1 | (case >> c & 1) as u8);
                let on_face = |&&[a, b]: &&[u8; 2]| shared_face(a, b) == Some(face);
                let turn = |[a, b]: [[usize; 2]; 2]| if side == 1 { [a, b] } else { [b, a] };
                let mut lines: Vec<_> = border
                    .iter()
                    .filter(on_face)
                    .map(|&[a, b]| turn([in_face(a, face), in_face(b, face)]))
                    .collect();
                lines.sort_unstable();
                drawn.entry((axis, bits)).or_default()[side].insert(lines);
            }
        }
    }
    assert_eq!(drawn.len(), 3 * 16);
    for ((_, bits), [lower, upper]) in drawn {
        assert_eq!(lower, upper, "{bits:04b}");
        let is_ambiguous = bits == 0b0110 || bits == 0b1001;
        assert_eq!(lower.len(), if is_ambiguous { 2 } else { 1 });
    }
}

#[test]
fn a_single_inside_corner_is_wrapped_outward_and_mirrored_the_other_way() {
    for corner in 0..8usize {
        let row = |mirrored| {
            let tables = Tables::get(mirrored);
            tables.rows[usize::from(tables.first_row[1 << corner])].clone()
        };
        let [straight, mirrored] = [row(false), row(true)].map(|row| triangles(&row)[0]);
        let middle = |edge: u8| {
            let [a, b] = edge_corners(edge.into());
            [0, 1, 2].map(|k| ((a >> k & 1) + (b >> k & 1)) as f64 / 2.0)
        };
        let [p, q, r] = straight.map(middle);
        let side = |a: [f64; 3], b: [f64; 3]| [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let (u, v) = (side(p, q), side(p, r));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        for axis in 0..3 {
            let outward = if corner >> axis & 1 == 0 { 1.0 } else { -1.0 };
            assert!(normal[axis] * outward > 0.0, "corner {corner}");
        }
        assert_eq!([mirrored[0], mirrored[2], mirrored[1]], straight);
    }
}

#[test]
fn rows_use_the_crossed_edges_of_their_case() {
    let tables = Tables::get(false);
    for case in 0..256usize {
        let crossed: BTreeSet<u8> =
            (0..12).filter(|&edge| is_crossed(case as u8, edge.into())).collect();
        for number in plain_rows(case) {
            let used: BTreeSet<u8> = triangles(&tables.rows[number]).concat().into_iter().collect();
            let on_edges: BTreeSet<u8> = used.into_iter().filter(|&v| v < 12).collect();
            assert_eq!(on_edges, crossed, "case {case}");
        }
    }
}
