//! Two loops of a cell joined by a tunnel: an annulus between them, by rule.
//!
//! Knows loops and the numbering of the cell, no values. Builds candidates; whether one is a sound
//! patch is for `sound` to say.

use super::cube::{corner, corner_at, edge_corners, edge_of};

/// The local id of a cell's first wall vertex; 12 to 14, in rising order of their faces.
pub(super) const FIRST_WALL: u8 = 12;

/// An annulus between two loops of a cell.
pub(super) struct Annulus {
    /// Its triangles, in no particular direction.
    pub(super) triangles: Vec<[u8; 3]>,
    /// The faces that its wall vertices stand before, rising; as many as it has walls.
    pub(super) walls: Vec<u8>,
    /// The axis of the band faces where both loops have four vertices and the annulus has two
    /// forms; 0 to 2.
    pub(super) axis: Option<u8>,
}

/// The annuli by which a tunnel may join two of `lines`, one or, where it has two forms, two.
/// `inside` says which corners it connects, those inside or those outside; `bands` are the
/// ambiguous faces across which the others are joined.
pub(super) fn annuli(case: u8, lines: &[Vec<u8>], bands: u8, inside: bool) -> Vec<Annulus> {
    let side = if inside { case } else { !case };
    for line in lines {
        if let Some(p) = tip(line).filter(|&p| side >> p & 1 == 1) {
            return from_triangle(p, bands).into_iter().collect();
        }
    }
    (0..3).flat_map(|axis| between_edges(axis, side, bands)).collect()
}

/// The corner that a loop of three cuts off.
pub(super) fn tip(line: &[u8]) -> Option<usize> {
    let &[a, b, c] = line else { return None };
    let [a, b, c] = [a, b, c].map(|e| edge_corners(e.into()));
    a.into_iter().find(|p| b.contains(p) && c.contains(p))
}

/// From the loop of three around corner `p` to the loop that faces it from the corner opposite.
///
/// Six triangles go round between the three edges at `p` and three vertices beyond: a wall vertex
/// before each band face, the edge at the opposite corner otherwise. What a wall leaves open
/// towards the other loop is filled by triangles at its edges.
fn from_triangle(p: usize, bands: u8) -> Option<Annulus> {
    let opposite = p ^ 7;
    let face = |d: usize| 2 * d + corner_at(p)[d];
    let is_band = |d: usize| bands >> face(d) & 1 == 1;
    let walls: Vec<u8> = (0..3).filter(|&d| is_band(d)).map(|d| face(d) as u8).collect();
    if walls.len() != bands.count_ones() as usize {
        return None;
    }
    let near = |d: usize| edge_of(p, d) as u8;
    let far = |d: usize| match walls.iter().position(|&wall| wall == face(d) as u8) {
        Some(k) => FIRST_WALL + k as u8,
        None => edge_of(opposite, d) as u8,
    };
    // The edge along `axis` at the neighbour, along `step`, of the opposite corner.
    let rim = |step: usize, axis: usize| edge_of(opposite ^ 1 << step, axis) as u8;
    let mut triangles = Vec::new();
    for d in 0..3 {
        let (d1, d2) = ((d + 1) % 3, (d + 2) % 3);
        triangles.push([near(d1), near(d2), far(d)]);
        triangles.push([near(d), far(d1), far(d2)]);
        if is_band(d) {
            triangles.push([far(d), rim(d, d1), rim(d, d2)]);
        }
        let (w1, w2) = (rim(d1, d2), rim(d2, d1));
        match (is_band(d1), is_band(d2)) {
            (true, true) => {
                triangles.push([far(d1), w1, w2]);
                triangles.push([far(d1), w2, far(d2)]);
            }
            (true, false) => triangles.push([far(d1), w1, far(d2)]),
            (false, true) => triangles.push([far(d2), w2, far(d1)]),
            (false, false) => {}
        }
    }
    Some(Annulus { triangles, walls, axis: None })
}

/// Between two loops of four around opposite edges along `axis`, whose band faces are the two
/// faces across that axis: one form for each diagonal along which the tunnel may lie, that of
/// positive `alpha` products first.
fn between_edges(axis: usize, side: u8, bands: u8) -> Vec<Annulus> {
    if bands != 0b11 << (2 * axis) {
        return Vec::new();
    }
    let (d1, d2) = ((axis + 1) % 3, (axis + 2) % 3);
    let at = |h: usize, i: usize, j: usize| {
        let mut place = [0; 3];
        (place[axis], place[d1], place[d2]) = (h, i, j);
        corner(place)
    };
    let has = |i: usize, j: usize| (0..2).all(|h| side >> at(h, i, j) & 1 == 1);
    let Some(j) = (0..2).find(|&j| has(0, j) && has(1, 1 - j)) else { return Vec::new() };
    let edges = |axis: usize, i: usize, j: usize| [0, 1].map(|h| edge_of(at(h, i, j), axis) as u8);
    let (a, b) = (edges(d1, 0, j), edges(d2, 0, j));
    let (c, e) = (edges(d1, 1, 1 - j), edges(d2, 1, 1 - j));
    let wall = [FIRST_WALL, FIRST_WALL + 1];
    let form = |g: usize| {
        let mut triangles = Vec::new();
        for h in 0..2 {
            triangles.push([wall[h], a[h], b[h]]);
            triangles.push([wall[h], c[h], e[h]]);
        }
        for (x, y) in [(a, e), (b, c)] {
            triangles.push([wall[1 - g], x[0], x[1]]);
            triangles.push([wall[1 - g], x[g], y[1 - g]]);
            triangles.push([wall[g], x[g], y[1 - g]]);
            triangles.push([wall[g], y[0], y[1]]);
        }
        let walls = vec![2 * axis as u8, 2 * axis as u8 + 1];
        Annulus { triangles, walls, axis: Some(axis as u8) }
    };
    vec![form(0), form(1)]
}

/// Turns triangles so that all go round alike, the way of the segments of `lines` that they hold.
pub(super) fn orient(triangles: &mut [[u8; 3]], lines: &[Vec<u8>]) {
    let mut wanted: Vec<[u8; 2]> = lines
        .iter()
        .flat_map(|line| (0..line.len()).map(|k| [line[k], line[(k + 1) % line.len()]]))
        .collect();
    let mut done = vec![false; triangles.len()];
    while let Some([from, to]) = wanted.pop() {
        for (triangle, done) in triangles.iter_mut().zip(&mut done) {
            if *done || !(triangle.contains(&from) && triangle.contains(&to)) {
                continue;
            }
            if sides(*triangle).contains(&[to, from]) {
                triangle.swap(1, 2);
            }
            *done = true;
            wanted.extend(sides(*triangle).map(|[a, b]| [b, a]));
        }
    }
}

/// The three directed sides of a triangle.
pub(super) fn sides([a, b, c]: [u8; 3]) -> [[u8; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}
