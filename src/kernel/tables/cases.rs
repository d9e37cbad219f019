//! All ways in which the surface may pass through a cell, as tables made by rule.
//!
//! A *row* is the triangles of one cell. The fast tables, indexed by a cell's case byte, serve the
//! half of the cases that its corners settle alone; the rest choose among the rows of their case
//! (`settle`). Built once, from `loops`, `fan` and `tunnel`; nothing here depends on a volume.

use std::sync::LazyLock;

use super::cube::{face_corners, is_crossed};
use super::fan::{CENTRE, fan};
use super::loops::{ambiguous_faces, loops};
use super::sound::is_sound;
use super::tunnel::{annuli, orient, tip};

/// The triangles of one cell.
///
/// They name vertices by *local id*, the cell's own numbering: 0 to 11 its edges (`cube`), 12 to 14 its
/// wall vertices, 15 its centre vertex. A row has walls or a centre or neither, never both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// How many triangles; at most 16.
    pub n_triangles: u8,
    /// How many wall vertices, local ids 12 and on; at most 3. They come in the order of `walls`.
    pub n_walls: u8,
    /// How many centre vertices, local id 15; 0 or 1.
    pub n_centres: u8,
    /// Three local ids a triangle, counter-clockwise seen from outside the surface, sixteen to a block.
    pub ids: [[u8; 16]; 3],
    /// The faces before which the walls stand, rising.
    pub(in crate::kernel) walls: [u8; 3],
    /// The axis across which two loops of four face each other in a tunnel; else 3.
    pub(in crate::kernel) axis: u8,
    /// The edges of the loop that the centre fills, one bit each.
    pub(in crate::kernel) centre_loop: u16,
    /// The corner that a loop of three cuts off beside a centre; else 8.
    pub(in crate::kernel) beside: u8,
    /// For a row without a tunnel, those with one that joins outside or inside corners: their
    /// numbers, 0 for none. Where a tunnel has two forms, the second follows the first.
    pub(in crate::kernel) tunnels: [u16; 2],
}

impl Row {
    /// The triangles, three local ids each.
    pub fn triangles(&self) -> impl Iterator<Item = [u8; 3]> {
        let (triangles, _) = self.ids.as_flattened().as_chunks::<3>();
        triangles.iter().take(self.n_triangles.into()).copied()
    }
}

/// The tables for one winding.
pub struct Tables {
    /// How many triangles a case has; 0 where the case leaves the cell unsettled.
    pub n_triangles: [u8; 256],
    /// Whether the corners alone do not say what the surface is: an ambiguous face, or two corners
    /// opposite each other between which there may be a tunnel.
    pub is_unsettled: [bool; 256],
    /// The first block of the case's first row: three local ids a triangle. (For unsettled
    /// cases: the row whose faces join nothing.)
    pub ids: [[u8; 16]; 256],
    /// By how much a cell moves the running id of each local id on. X edges, 0 to 3, have ids of
    /// their own; the four of Y edges and of Z edges follow the cell's right-hand edge, left
    /// and right alike. 0 for 12 to 15.
    pub crossed: [[u8; 16]; 256],
    /// All rows: those of a case side by side, in the order of the bits of its ambiguous faces,
    /// then those with a tunnel.
    pub rows: Vec<Row>,
    /// The first row of each case.
    pub first_row: [u16; 256],
    /// The ambiguous faces of each case, rising: its two inside corners, then its two outside ones.
    pub(in crate::kernel) ambiguous: [[[u8; 4]; 6]; 256],
    /// How many those are.
    pub(in crate::kernel) n_ambiguous: [u8; 256],
}

impl Tables {
    /// How many rows have no tunnel: those come first.
    pub const N_PLAIN_ROWS: usize = 656;

    /// The tables whose triangles are counter-clockwise seen from outside, or, `mirrored`, the
    /// other way round: for maps that turn the space inside out.
    pub fn get(mirrored: bool) -> &'static Self {
        static STRAIGHT: LazyLock<Tables> = LazyLock::new(|| Tables::new(false));
        static MIRRORED: LazyLock<Tables> = LazyLock::new(|| Tables::new(true));
        if mirrored { &MIRRORED } else { &STRAIGHT }
    }

    fn new(mirrored: bool) -> Self {
        let mut rows = Vec::new();
        let mut first_row = [0; 256];
        for case in 0..=255 {
            first_row[case as usize] = rows.len() as u16;
            for joined in combinations(ambiguous_faces(case)) {
                rows.push(plain_row(case, joined, mirrored));
            }
        }
        let mut is_unsettled = [false; 256];
        for case in 0..=255 {
            let first = first_row[case as usize];
            let faces = ambiguous_faces(case);
            is_unsettled[case as usize] = faces != 0;
            for (row, joined) in (first..).zip(combinations(faces)) {
                for inside in [false, true] {
                    let found = tunnel_rows(case, joined, inside, mirrored);
                    if !found.is_empty() {
                        rows[row as usize].tunnels[usize::from(inside)] = rows.len() as u16;
                        is_unsettled[case as usize] = true;
                    }
                    rows.extend(found);
                }
            }
        }
        let mut tables = Self {
            n_triangles: [0; 256],
            is_unsettled,
            ids: [[0; 16]; 256],
            crossed: [[0; 16]; 256],
            rows,
            first_row,
            ambiguous: [[[0; 4]; 6]; 256],
            n_ambiguous: [0; 256],
        };
        for case in 0..256 {
            let faces = ambiguous_faces(case as u8);
            let corners = (0..6).filter(|face| faces >> face & 1 == 1).map(face_corners);
            for (slot, [a, b, c, d]) in tables.ambiguous[case].iter_mut().zip(corners) {
                let (inside, outside) =
                    if case >> a & 1 == 1 { ([a, c], [b, d]) } else { ([b, d], [a, c]) };
                *slot = [inside[0], inside[1], outside[0], outside[1]].map(|c| c as u8);
                tables.n_ambiguous[case] += 1;
            }
        }
        for case in 0..256 {
            let row = &tables.rows[usize::from(first_row[case])];
            tables.ids[case] = row.ids[0];
            tables.n_triangles[case] = if is_unsettled[case] { 0 } else { row.n_triangles };
            for id in 0..12 {
                // Edge 4 + z + 2x, 8 + x + 2y: the right-hand edge is the one with the x bit set.
                let counted = [id, id | 2, id | 1][id / 4];
                tables.crossed[case][id] = is_crossed(case as u8, counted).into();
            }
        }
        tables
    }
}

/// All subsets of a set of faces, in the order of their bits pushed together.
fn combinations(faces: u8) -> impl Iterator<Item = u8> {
    let places: Vec<u8> = (0..6).filter(|face| faces >> face & 1 == 1).collect();
    (0..1u8 << places.len()).map(move |bits| {
        places.iter().enumerate().fold(0, |set, (k, face)| set | (bits >> k & 1) << face)
    })
}

/// The row whose loops are filled one by one.
fn plain_row(case: u8, joined: u8, mirrored: bool) -> Row {
    let lines = loops(case, joined);
    let triangles = lines.iter().flat_map(|line| fan(line)).collect::<Vec<_>>();
    debug_assert!(is_sound(&triangles, &lines, lines.len() as i32), "{case} {joined}");
    let mut row = row(&triangles, mirrored);
    if let Some(line) = lines.iter().find(|line| fan(line)[0][0] == CENTRE) {
        row.n_centres = 1;
        row.centre_loop = line.iter().fold(0, |set, edge| set | 1 << edge);
        row.beside = lines.iter().find_map(|line| tip(line)).unwrap_or(8) as u8;
    }
    row
}

/// The rows in which a tunnel joins the corners inside, or those outside: none, one, or two forms
/// of one. A candidate is a row if it is a sound patch.
fn tunnel_rows(case: u8, joined: u8, inside: bool, mirrored: bool) -> Vec<Row> {
    let lines = loops(case, joined);
    let faces = ambiguous_faces(case);
    let bands = if inside { faces & !joined } else { joined };
    let mut found = Vec::new();
    for annulus in annuli(case, &lines, bands, inside) {
        let mut triangles = annulus.triangles;
        orient(&mut triangles, &lines);
        let used = triangles.concat();
        for line in lines.iter().filter(|line| !used.contains(&line[0])) {
            triangles.extend(fan(line));
        }
        if is_sound(&triangles, &lines, lines.len() as i32 - 2) {
            let mut row = row(&triangles, mirrored);
            row.n_walls = annulus.walls.len() as u8;
            row.walls[..annulus.walls.len()].copy_from_slice(&annulus.walls);
            row.axis = annulus.axis.unwrap_or(3);
            found.push(row);
        }
    }
    found
}

/// A row of triangles given in the direction of the loops, which have the inside on their left and
/// so face inwards: wound outward here, unless mirrored.
fn row(triangles: &[[u8; 3]], mirrored: bool) -> Row {
    let mut ids = [0; 48];
    for (slot, &[a, b, c]) in ids.chunks_exact_mut(3).zip(triangles) {
        slot.copy_from_slice(&if mirrored { [a, b, c] } else { [a, c, b] });
    }
    let mut blocks = [[0; 16]; 3];
    blocks.as_flattened_mut().copy_from_slice(&ids);
    Row {
        n_triangles: triangles.len() as u8,
        n_walls: 0,
        n_centres: 0,
        ids: blocks,
        walls: [0; 3],
        axis: 3,
        centre_loop: 0,
        beside: 8,
        tunnels: [0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_656_rows_without_and_160_with_a_tunnel() {
        let rows = &Tables::get(false).rows;
        assert_eq!(rows.len(), 816);
        let (plain, tunnels) = rows.split_at(Tables::N_PLAIN_ROWS);
        assert_eq!(plain.iter().filter(|row| row.tunnels != [0, 0]).count(), 140);
        assert_eq!(plain.iter().filter(|row| row.n_centres == 1).count(), 140);
        assert_eq!(tunnels.iter().filter(|row| row.axis < 3).count(), 24);
        let links: usize =
            plain.iter().flat_map(|row| row.tunnels).filter(|&tunnel| tunnel != 0).count();
        assert_eq!(links, 148);
    }
}
