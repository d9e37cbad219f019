//! The closed lines in which the surface meets the boundary of a cell.
//!
//! Follows a face's four inside bits and its decider alone, so that both cells at a face draw the
//! same segments. Knows no triangles and no values.

use super::cube::{edge_between, face_corners, is_ambiguous, is_crossed};

/// The faces of a case whose inside corners are two on one diagonal, one bit each.
pub(super) fn ambiguous_faces(case: u8) -> u8 {
    (0..6).filter(|&face| is_ambiguous(case, face)).fold(0, |mask, face| mask | 1 << face)
}

/// The loops of a case: edges in order, with the inside on the left seen from outside the cell.
/// `joined` has a bit for each ambiguous face whose inside corners are joined across it.
///
/// On each face, going round it counter-clockwise, a run of inside corners is left over one edge
/// and was entered over another. The segment goes from where it is left to where the same run was
/// entered, or, where the face joins them, to where the next run is.
pub(super) fn loops(case: u8, joined: u8) -> Vec<Vec<u8>> {
    let next = segments(case, joined);
    let mut seen = [false; 12];
    let mut loops = Vec::new();
    for start in 0..12 {
        if seen[start] || !is_crossed(case, start) {
            continue;
        }
        let mut line = Vec::new();
        let mut at = start;
        while !seen[at] {
            seen[at] = true;
            line.push(at as u8);
            at = next[at];
        }
        loops.push(line);
    }
    loops
}

/// For each crossed edge, the edge to which its outgoing segment leads.
fn segments(case: u8, joined: u8) -> [usize; 12] {
    let inside = |corner: usize| case >> corner & 1 == 1;
    let mut next = [usize::MAX; 12];
    for face in 0..6 {
        let corners = face_corners(face);
        let edge = |side: usize| edge_between(corners[side % 4], corners[(side + 1) % 4]);
        let enters = |side: usize| !inside(corners[side % 4]) && inside(corners[(side + 1) % 4]);
        for side in 0..4 {
            if !inside(corners[side]) || inside(corners[(side + 1) % 4]) {
                continue;
            }
            let back = if joined >> face & 1 == 1 && is_ambiguous(case, face) {
                side + 1
            } else {
                // The run's own entry: the nearest one behind.
                (1..4).map(|steps| side + 4 - steps).find(|&k| enters(k)).unwrap_or(side)
            };
            next[edge(side)] = edge(back);
        }
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_have_the_lengths_that_the_plain_rule_gives() {
        let mut lengths = [0; 13];
        for case in 0..=255 {
            for line in loops(case, 0) {
                lengths[line.len()] += 1;
            }
        }
        assert_eq!(lengths, [0, 0, 0, 144, 66, 72, 52, 24, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn every_crossed_edge_is_in_one_loop_whatever_the_faces_say() {
        let mut counts = [0; 7];
        for case in 0..=255u8 {
            counts[ambiguous_faces(case).count_ones() as usize] += 1;
            for joined in 0..64 {
                let found = loops(case, joined);
                let mut edges: Vec<u8> = found.concat();
                edges.sort_unstable();
                let crossed: Vec<u8> = (0..12).filter(|&e| is_crossed(case, e as usize)).collect();
                assert_eq!(edges, crossed);
                assert!(found.len() <= 4);
                assert!(found.iter().all(|line| matches!(line.len(), 3..=9 | 12)));
            }
        }
        assert_eq!(counts, [136, 72, 30, 16, 0, 0, 2]);
    }
}
