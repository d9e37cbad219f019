//! The numbering of a cell's corners, edges and faces, drawn once.
//!
//! ```text
//!        6------7        corner i = x + 2y + 4z
//!       /|     /|        edge   e = 4·axis + b1 + 2·b2, (b1, b2) its coordinates
//!      4------5 |                   along the axes axis+1 and axis+2 (mod 3)
//!      | 2----|-3        face   f = 2·axis + side
//!      |/     |/
//!      0------1          x to the right, y into the page, z up
//! ```
//!
//! Pure combinatorics: knows no values, no positions in a volume, no triangles.

/// The corner at (x, y, z), each 0 or 1.
pub const fn corner(at: [usize; 3]) -> usize {
    at[0] + 2 * at[1] + 4 * at[2]
}

/// Where a corner is, each coordinate 0 or 1.
pub const fn corner_at(corner: usize) -> [usize; 3] {
    [corner & 1, corner >> 1 & 1, corner >> 2 & 1]
}

/// The axis along which an edge runs.
pub const fn edge_axis(edge: usize) -> usize {
    edge / 4
}

/// The two corners of an edge, the lower one first.
pub const fn edge_corners(edge: usize) -> [usize; 2] {
    let axis = edge_axis(edge);
    let low = (edge & 1) << ((axis + 1) % 3) | (edge >> 1 & 1) << ((axis + 2) % 3);
    [low, low | 1 << axis]
}

/// The edge at a corner along an axis.
pub const fn edge_of(corner: usize, axis: usize) -> usize {
    4 * axis + (corner >> ((axis + 1) % 3) & 1) + 2 * (corner >> ((axis + 2) % 3) & 1)
}

/// The corners of a face, counter-clockwise seen from outside the cell.
pub const fn face_corners(face: usize) -> [usize; 4] {
    let [p00, p10, p11, p01] = slice_corners(face / 2, face & 1);
    if face & 1 == 1 { [p00, p10, p11, p01] } else { [p01, p11, p10, p00] }
}

/// The corners of a cell on one side of an axis: p00, p10, p11, p01 in the axes axis+1 and axis+2.
pub const fn slice_corners(axis: usize, side: usize) -> [usize; 4] {
    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let at = side << axis;
    [at, at | u, at | u | v, at | v]
}

/// The edge between two corners of one face that follow each other.
pub const fn edge_between(a: usize, b: usize) -> usize {
    edge_of(a, (a ^ b).trailing_zeros() as usize)
}

/// The faces that hold an edge, one bit each.
pub const fn faces_of(edge: usize) -> u8 {
    let at = corner_at(edge_corners(edge)[0]);
    let (u, v) = ((edge_axis(edge) + 1) % 3, (edge_axis(edge) + 2) % 3);
    1 << (2 * u + at[u]) | 1 << (2 * v + at[v])
}

/// Whether some face of the cell holds both edges. A triangle's edge between vertices on two such
/// grid edges would lie in that face, where the neighbour may draw it as well.
pub const fn share_face(a: usize, b: usize) -> bool {
    faces_of(a) & faces_of(b) != 0
}

/// Whether the surface crosses an edge in a case: one end is inside, the other is not.
pub const fn is_crossed(case: u8, edge: usize) -> bool {
    let [a, b] = edge_corners(edge);
    (case >> a ^ case >> b) & 1 == 1
}

/// The point on an edge a part `t` of the way from its lower corner, in the cell's own coordinates.
pub fn edge_point(edge: usize, t: f64) -> [f64; 3] {
    let mut point = corner_at(edge_corners(edge)[0]).map(|x| x as f64);
    point[edge_axis(edge)] = t;
    point
}

/// Whether a face's inside corners are two, on one diagonal.
pub const fn is_ambiguous(case: u8, face: usize) -> bool {
    let [a, b, c, d] = face_corners(face);
    let (a, b, c, d) = (case >> a & 1, case >> b & 1, case >> c & 1, case >> d & 1);
    a == c && b == d && a != b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_edges_and_faces_name_each_other() {
        for edge in 0..12 {
            let [low, high] = edge_corners(edge);
            assert_eq!(high - low, 1 << edge_axis(edge));
            assert_eq!(edge_of(low, edge_axis(edge)), edge);
            assert_eq!(edge_between(high, low), edge);
            assert_eq!(faces_of(edge).count_ones(), 2);
            assert_eq!((0..12).filter(|&other| share_face(edge, other)).count(), 7, "itself, six");
        }
        for corner_id in 0..8 {
            assert_eq!(corner(corner_at(corner_id)), corner_id);
        }
    }

    #[test]
    fn face_corners_turn_counter_clockwise_seen_from_outside() {
        for face in 0..6 {
            let [a, b, c, _] = face_corners(face).map(|i| corner_at(i).map(|x| x as f64));
            let normal = crate::geom::vec3::cross(
                crate::geom::vec3::sub(b, a),
                crate::geom::vec3::sub(c, b),
            );
            let outward = if face & 1 == 1 { 1.0 } else { -1.0 };
            assert_eq!(normal[face / 2], outward, "face {face}");
        }
    }
}
