//! Where the vertices inside a cell lie: walls of a tunnel, centres of loops.
//!
//! In the cell's own coordinates, 0 to 1 along each axis. Knows values and the local ids of a row, not
//! where the cell is.

use super::decide::{Waist, gradient, trilinear};
use super::tables::Row;
use super::tables::cube::{corner_at, edge_of, edge_point};
use crate::geom::vec3::{cross, norm, sub};

type Point = [f64; 3];

/// Parameters of the twelve edges' vertices, from the lower corner.
pub(super) type Crossings = [f64; 12];

/// The wall vertices of a row with a tunnel, if none of its triangles is thinner than `epsilon / 4`.
/// Each is a corner of the tunnel's hexagon, so on the surface, and inside the cell, a step of
/// `epsilon` at least from its faces and from the others.
pub(super) fn walls(row: &Row, waist: &Waist, t: &Crossings, epsilon: f64) -> Option<[Point; 3]> {
    let ends = [1.0, -1.0].map(|sign| {
        [0, 1, 2].map(|axis| {
            let middle = waist.middle[axis].max(2.0 * epsilon).min(1.0 - 2.0 * epsilon);
            let half = waist.half[axis].abs().max(epsilon).copysign(waist.half[axis]);
            (middle + sign * half).max(epsilon).min(1.0 - epsilon)
        })
    });
    let mut walls = [[0.0; 3]; 3];
    for (wall, &face) in walls.iter_mut().zip(&row.walls[..row.n_walls.into()]) {
        let (axis, is_upper) = (usize::from(face / 2), face & 1 == 1);
        // Along the face's axis the nearer of the two ends, along the others the other one.
        let near = usize::from((waist.half[axis] > 0.0) != is_upper);
        *wall = ends[1 - near];
        wall[axis] = ends[near][axis];
    }
    let place = |id: u8| match id {
        0..12 => edge_point(id.into(), t[usize::from(id)]),
        _ => walls[usize::from(id - 12)],
    };
    row.triangles().all(|ids| altitude(ids.map(place)) >= epsilon / 4.0).then_some(walls)
}

/// The centre vertex of a row that has one: the mean of its loop's vertices, moved towards the
/// surface where that helps.
pub(super) fn centre(row: &Row, values: &[f64; 8], t: &Crossings) -> Point {
    let line = (0..12).filter(|edge| row.centre_loop >> edge & 1 == 1);
    let mut sum = [0.0; 3];
    for point in line.map(|edge| edge_point(edge, t[edge])) {
        sum = [0, 1, 2].map(|axis| sum[axis] + point[axis]);
    }
    let mean = sum.map(|x| x / f64::from(row.centre_loop.count_ones()));
    let start = trilinear(values, mean).abs();
    let (mut best, mut least) = (mean, start);
    for _ in 0..3 {
        let slope = gradient(values, best);
        let by = trilinear(values, best) / slope.iter().map(|g| g * g).sum::<f64>();
        let next =
            [0, 1, 2].map(|axis| (best[axis] - by * slope[axis]).clamp(MARGIN, 1.0 - MARGIN));
        let off = trilinear(values, next).abs();
        // False where anything is not finite.
        if off < least {
            (best, least) = (next, off);
        } else {
            break;
        }
    }
    if least < start && is_beyond(row.beside, best, t) { best } else { mean }
}

/// A centre stays this far from the faces of its cell.
const MARGIN: f64 = 1.0 / 16.0;

/// Whether a point lies beyond the triangle that cuts off a corner, seen from that corner; true
/// where there is none.
fn is_beyond(corner: u8, point: Point, t: &Crossings) -> bool {
    if corner >= 8 {
        return true;
    }
    let at = corner_at(corner.into());
    let reach = |axis: usize| {
        let t = t[edge_of(corner.into(), axis)];
        if at[axis] == 0 { point[axis] / t } else { (1.0 - point[axis]) / (1.0 - t) }
    };
    reach(0) + reach(1) + reach(2) > 1.001
}

/// The least altitude of a triangle.
fn altitude([a, b, c]: [Point; 3]) -> f64 {
    let sides = [sub(b, a), sub(c, b), sub(a, c)];
    let longest = sides.iter().map(|&side| norm(side)).fold(0.0, f64::max);
    norm(cross(sides[0], sides[1])) / longest
}
