//! Whether the triangles of one cell are a sound patch: what the table accepts as a row.
//!
//! Knows local ids only: no values, no positions.

use super::cube::share_face;
use super::tunnel::sides;

/// Whether triangles, in the direction of the loops, have just the loops as their border, use no
/// edge twice the same way, draw nothing else into a face of the cell, go once round each of
/// their vertices, and have the Euler number `euler`.
pub(super) fn is_sound(triangles: &[[u8; 3]], lines: &[Vec<u8>], euler: i32) -> bool {
    let mut halves: Vec<[u8; 2]> = triangles.iter().flat_map(|&t| sides(t)).collect();
    halves.sort_unstable();
    if halves.windows(2).any(|pair| pair[0] == pair[1]) || halves.iter().any(|[a, b]| a == b) {
        return false;
    }
    let (inner, border): (Vec<[u8; 2]>, Vec<[u8; 2]>) =
        halves.iter().partition(|[a, b]| halves.binary_search(&[*b, *a]).is_ok());
    let mut segments: Vec<[u8; 2]> = lines
        .iter()
        .flat_map(|line| (0..line.len()).map(|k| [line[k], line[(k + 1) % line.len()]]))
        .collect();
    segments.sort_unstable();
    let in_face = |&[a, b]: &[u8; 2]| a < 12 && b < 12 && share_face(a.into(), b.into());
    let mut vertices: Vec<u8> = triangles.concat();
    vertices.sort_unstable();
    vertices.dedup();
    let n_edges = inner.len() / 2 + border.len();
    border == segments
        && !inner.iter().any(in_face)
        && vertices.iter().all(|&v| turns_once(triangles, v))
        && vertices.len() as i32 - n_edges as i32 + triangles.len() as i32 == euler
}

/// Whether the triangles at a vertex follow each other: in one open fan at an edge's vertex, in
/// one closed fan at an extra vertex.
fn turns_once(triangles: &[[u8; 3]], vertex: u8) -> bool {
    let spokes: Vec<[u8; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]])
        .filter(|turned| turned[0] == vertex)
        .map(|[_, b, c]| [b, c])
        .collect();
    let starts: Vec<u8> =
        spokes.iter().map(|s| s[0]).filter(|b| spokes.iter().all(|s| s[1] != *b)).collect();
    let first = match (starts.as_slice(), vertex < 12) {
        (&[start], true) => start,
        ([], false) => match spokes.first() {
            Some(spoke) => spoke[0],
            None => return false,
        },
        _ => return false,
    };
    let mut at = first;
    let mut n = 0;
    while let Some([_, next]) = spokes.iter().find(|s| s[0] == at) {
        (at, n) = (*next, n + 1);
        if at == first || n > spokes.len() {
            break;
        }
    }
    n == spokes.len()
}
