//! What happens inside one cell: every class occurs and is told apart, triangles do not cross, and
//! nothing leaves the cell, whatever the values.

use std::collections::{BTreeMap, BTreeSet};

use mcubes::kernel::cube::{edge_axis, edge_corners, face_corners, is_ambiguous};
use mcubes::kernel::{CellSurface, Tables, crossing, settle};

use crate::support::random::Random;

type Point = [f64; 3];
const EPSILON: f64 = 1.0 / 1024.0;

/// Corner values of one case: heavy tails make the rare classes common.
fn values(random: &mut Random, case: u8) -> [f64; 8] {
    let power = random.between(1.0, 5.0);
    std::array::from_fn(|corner| {
        let size = random.between(0.02, 1.0).powf(power);
        if case >> corner & 1 == 1 { size } else { -size }
    })
}

fn edge_parameter(values: &[f64; 8], edge: usize) -> f64 {
    let [low, high] = edge_corners(edge);
    crossing(values[low], values[high], 0.0, EPSILON)
}

fn surface(case: u8, values: &[f64; 8]) -> CellSurface {
    settle(Tables::get(false), case, values, |edge| edge_parameter(values, edge), EPSILON)
}

/// The triangles of a settled cell: local ids, and the positions they have.
fn placed(surface: &CellSurface, values: &[f64; 8]) -> Vec<[(u8, Point); 3]> {
    let row = &Tables::get(false).rows[usize::from(surface.row)];
    let place = |id: u8| match id {
        0..12 => {
            let low = edge_corners(id.into())[0];
            let mut point = [0, 1, 2].map(|axis| (low >> axis & 1) as f64);
            point[edge_axis(id.into())] = edge_parameter(values, id.into());
            point
        }
        12..15 => surface.extra[usize::from(id - 12)],
        _ => surface.extra[0],
    };
    let n = 3 * usize::from(row.n_triangles);
    let ids = &row.ids.as_flattened()[..n];
    ids.chunks(3).map(|t| [t[0], t[1], t[2]].map(|id| (id, place(id)))).collect()
}

/// The faces whose inside corners are joined, by the bilinear interpolant's value at its saddle.
fn joined(case: u8, values: &[f64; 8]) -> u8 {
    let joins = |face: usize| {
        let [a, b, c, d] = face_corners(face).map(|corner| values[corner]);
        is_ambiguous(case, face) && (a * c - b * d) / (a + c - b - d) > 0.0
    };
    (0..6).filter(|&face| joins(face)).fold(0, |set, face| set | 1 << face)
}

/// The cube's 48 symmetries: the axis that each axis goes to, and which of those are turned round.
pub(crate) fn symmetries() -> impl Iterator<Item = ([usize; 3], usize)> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    orders.into_iter().flat_map(|order| (0..8).map(move |flips| (order, flips)))
}

/// Where a symmetry takes a corner.
pub(crate) fn moved((order, flips): ([usize; 3], usize), corner: usize) -> usize {
    (0..3).fold(0, |to, axis| to | (corner >> axis & 1) << order[axis]) ^ flips
}

/// What a cell is up to the cube's 48 symmetries and the exchange of inside and outside: its least
/// image.
type Class = (u8, u8, bool);

fn class(case: u8, joined: u8, tunnel: bool) -> Class {
    let ambiguous =
        (0..6).filter(|&face| is_ambiguous(case, face)).fold(0u8, |set, face| set | 1 << face);
    let mut least = (255, 255, tunnel);
    for (order, flips) in symmetries() {
        let corner = |c: usize| moved((order, flips), c);
        let face = |f: usize| 2 * order[f / 2] + (f & 1 ^ flips >> order[f / 2] & 1);
        for (case, joined) in [(case, joined), (!case, ambiguous & !joined)] {
            let case = (0..8).fold(0, |to, c| to | (case >> c & 1) << corner(c));
            let joined = (0..6).fold(0, |to, f| to | (joined >> f & 1) << face(f));
            least = least.min((case, joined, tunnel));
        }
    }
    least
}

/// At least `n` examples of each class that occurs, and of each row of the tables with a tunnel.
pub(crate) fn examples(random: &mut Random, n: usize) -> BTreeMap<Class, Vec<[f64; 8]>> {
    let mut classes: BTreeMap<Class, Vec<[f64; 8]>> = BTreeMap::new();
    let mut rows: BTreeMap<u16, usize> = BTreeMap::new();
    let mut draws: Vec<u8> = (0..=255).collect::<Vec<u8>>().repeat(2000);
    // Corners inside and outside by turns: the rarest tunnels.
    draws.extend([0x69, 0x96].repeat(100_000));
    for case in draws {
        let values = values(random, case);
        let surface = surface(case, &values);
        let tunnel = usize::from(surface.row) >= Tables::N_PLAIN_ROWS;
        let found = rows.entry(surface.row).or_default();
        *found += 1;
        if *found > n {
            continue;
        }
        let examples = classes.entry(class(case, joined(case, &values), tunnel)).or_default();
        if tunnel || examples.len() < n {
            examples.push(values);
        }
    }
    classes
}

#[test]
fn all_thirty_one_classes_and_all_tunnel_rows_occur_and_no_other() {
    let mut random = Random::new(11);
    let mut classes = BTreeSet::new();
    let mut rows = BTreeSet::new();
    let mut draws: Vec<u8> = (0..=255).collect::<Vec<u8>>().repeat(2000);
    // Corners inside and outside by turns: the rarest tunnels.
    draws.extend([0x69, 0x96].repeat(100_000));
    for case in draws {
        let values = values(&mut random, case);
        let surface = surface(case, &values);
        if rows.insert(surface.row) {
            classes.insert(class(
                case,
                joined(case, &values),
                usize::from(surface.row) >= Tables::N_PLAIN_ROWS,
            ));
        }
    }
    let tunnels = rows.iter().filter(|&&row| usize::from(row) >= Tables::N_PLAIN_ROWS).count();
    assert_eq!(classes.len(), 31, "{classes:?}");
    assert_eq!(tunnels, 160);
}

#[test]
fn triangles_of_a_cell_do_not_cross_and_stay_inside_it() {
    hold_apart(60);
}

/// `cargo test --release --test it cells -- --ignored`
#[test]
#[ignore = "eight million cells; minutes even with --release"]
fn triangles_of_a_cell_do_not_cross_at_length() {
    hold_apart(32_000);
}

fn hold_apart(n: usize) {
    let mut random = Random::new(12);
    for _ in 0..n {
        for case in 0..=255 {
            let values = values(&mut random, case);
            let surface = surface(case, &values);
            let triangles = placed(&surface, &values);
            for (_, point) in triangles.as_flattened() {
                assert!(point.iter().all(|x| (0.0..=1.0).contains(x)), "{case} {values:?}");
            }
            for point in &surface.extra[..surface.n_extra.into()] {
                let within = |x: &f64| (EPSILON..=1.0 - EPSILON).contains(x);
                assert!(point.iter().all(within), "{case} {values:?}");
            }
            for (n, a) in triangles.iter().enumerate() {
                for b in &triangles[..n] {
                    assert!(!cross(a, b), "{case} {values:?} {a:?} {b:?}");
                    assert!(!cross(b, a), "{case} {values:?} {a:?} {b:?}");
                }
            }
        }
    }
}

/// Whether an edge of `a` passes through `b` at a point that is no corner of either.
fn cross(a: &[(u8, Point); 3], b: &[(u8, Point); 3]) -> bool {
    let shared = |id: u8| b.iter().any(|(other, _)| *other == id);
    (0..3).any(|k| {
        let (from, to) = (a[k], a[(k + 1) % 3]);
        if shared(from.0) || shared(to.0) {
            return false;
        }
        let [p, q, r] = b.map(|(_, point)| point);
        let (u, v) = (from.1, to.1);
        let sides = [side(p, q, r, u), side(p, q, r, v)];
        let turns = [side(u, v, p, q), side(u, v, q, r), side(u, v, r, p)];
        // Below this a volume is rounding.
        let least = 1e-14;
        sides[0].abs() > least
            && sides[1].abs() > least
            && (sides[0] > 0.0) != (sides[1] > 0.0)
            && (turns.iter().all(|&t| t > least) || turns.iter().all(|&t| t < -least))
    })
}

/// Six times the volume of a tetrahedron: on which side of the plane through three points a fourth
/// lies.
fn side(p: Point, q: Point, r: Point, s: Point) -> f64 {
    let d = |a: Point| [a[0] - p[0], a[1] - p[1], a[2] - p[2]];
    let (a, b, c) = (d(q), d(r), d(s));
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[test]
fn values_that_are_not_finite_or_tie_leave_a_sound_cell() {
    let mut random = Random::new(13);
    let odd = [f64::NAN, f64::INFINITY, 1e308, 1e-320, 0.0, 1.0, 2.0, 1e200];
    for _ in 0..400 {
        for case in 0..=255u8 {
            let values: [f64; 8] = std::array::from_fn(|corner| {
                let size = odd[random.below(8) as usize];
                if case >> corner & 1 == 1 { size } else { -size }
            });
            let surface = surface(case, &values);
            if values.iter().any(|v| !v.is_finite()) {
                assert!(
                    usize::from(surface.row) < Tables::N_PLAIN_ROWS,
                    "no tunnel among {values:?}"
                );
            }
            for point in &surface.extra[..surface.n_extra.into()] {
                let within = |x: &f64| (EPSILON..=1.0 - EPSILON).contains(x);
                assert!(point.iter().all(within), "{case} {values:?} {point:?}");
            }
            for [a, b, c] in placed(&surface, &values) {
                let [a, b, c] = [a, b, c].map(|(_, point)| point.map(|x| x as f32));
                assert!(a != b && b != c && c != a, "{case} {values:?}");
            }
        }
    }
}
