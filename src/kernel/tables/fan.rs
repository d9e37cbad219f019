//! A loop filled by a disk.
//!
//! Knows loops and the numbering of the cell, no cases and no positions.

use super::cube::share_face;

/// The local id of a cell's centre vertex; 0 to 11 are edges, 12 to 14 walls.
pub(super) const CENTRE: u8 = 15;

/// Triangles that fill a loop, in the loop's direction: a fan from the first of its vertices from
/// which no triangle edge would run inside a face of the cell, otherwise from the centre vertex.
pub(super) fn fan(line: &[u8]) -> Vec<[u8; 3]> {
    let n = line.len();
    match (0..n).find(|&apex| is_legal(line, apex)) {
        Some(apex) => (1..n - 1)
            .map(|k| [line[apex], line[(apex + k) % n], line[(apex + k + 1) % n]])
            .collect(),
        None => (0..n).map(|k| [CENTRE, line[k], line[(k + 1) % n]]).collect(),
    }
}

/// Whether all chords from a vertex to those that are not its neighbours leave the faces.
fn is_legal(line: &[u8], apex: usize) -> bool {
    let n = line.len();
    (2..n - 1).all(|k| !share_face(line[apex].into(), line[(apex + k) % n].into()))
}
