//! The tables of marching tetrahedra: a cell cut into six along its main diagonal.
//!
//! Each tetrahedron has the corners 0, one step, two steps and three steps on towards 7, the steps
//! along the three axes in one of their six orders (Kuhn's split). Every face of the cell is cut
//! along the diagonal from its lowest to its highest corner, on both sides alike, so neighbours
//! agree. Inside a tetrahedron nothing is ambiguous: a cell's eight bits say all its triangles.
//!
//! Built once, by rule. Knows no values and no positions.

use std::sync::LazyLock;

/// How many edges a cell has: its own, its faces' diagonals and the main diagonal.
pub const N_TETRA_EDGES: usize = 19;

/// The tables for one winding.
///
/// Vertices are named by *local id*, the cell's own numbering of its edges. The first twelve are those
/// of `cube`; where a face has a diagonal, it runs from the face's lowest corner to its highest.
///
/// ```text
///        0..4   X edges, y + 2z
///       4..8   Y edges, z + 2x
///       8..12  Z edges, x + 2y
///      12, 13  XY diagonals, before (z = 0) and after (z = 1)
///      14, 15  XZ diagonals, of row r - 1 (y = 0) and of row r (y = 1)
///      16, 17  YZ diagonals, left (x = 0) and right (x = 1)
///          18  the main diagonal, from corner 0 to corner 7
/// ```
pub struct TetraTables {
    /// How many triangles a case has; at most 12.
    pub n_triangles: [u8; 256],
    /// Three local ids a triangle, counter-clockwise seen from outside, sixteen to a block.
    pub ids: [[[u8; 16]; 3]; 256],
    /// By how much a cell moves the running id of each local id on. Those whose edges no other cell of
    /// the row has (X edges, XY and XZ diagonals, the main diagonal) have ids of their own; the
    /// others follow the cell's right-hand edge, left and right alike: the left one is always the
    /// last that was counted.
    pub crossed: [[u8; 32]; 256],
}

impl TetraTables {
    /// The tables whose triangles are counter-clockwise seen from outside, or, `mirrored`, the
    /// other way round.
    pub fn get(mirrored: bool) -> &'static Self {
        static STRAIGHT: LazyLock<TetraTables> = LazyLock::new(|| TetraTables::new(false));
        static MIRRORED: LazyLock<TetraTables> = LazyLock::new(|| TetraTables::new(true));
        if mirrored { &MIRRORED } else { &STRAIGHT }
    }

    fn new(mirrored: bool) -> Self {
        let mut tables =
            Self { n_triangles: [0; 256], ids: [[[0; 16]; 3]; 256], crossed: [[0; 32]; 256] };
        for case in 0..=255u8 {
            let at = usize::from(case);
            let mut n = 0;
            let places = tables.ids[at].as_flattened_mut().chunks_exact_mut(3);
            for (place, [a, b, c]) in places.zip(triangles(case)) {
                place.copy_from_slice(&if mirrored { [a, c, b] } else { [a, b, c] });
                n += 1;
            }
            tables.n_triangles[at] = n;
            for edge in 0..N_TETRA_EDGES {
                let [a, b] = edge_ends(right(edge));
                tables.crossed[at][edge] = (case >> a ^ case >> b) & 1;
            }
        }
        tables
    }
}

/// The two corners of an edge, by its local id, the lower one first.
pub const fn edge_ends(edge: usize) -> [usize; 2] {
    let (low, step) = match edge {
        0..4 => (edge << 1, 1),
        4..8 => ((edge & 1) << 2 | (edge >> 1 & 1), 2),
        8..12 => (edge & 3, 4),
        12..14 => ((edge & 1) << 2, 3),
        14..16 => ((edge & 1) << 1, 5),
        16..18 => (edge & 1, 6),
        _ => (0, 7),
    };
    [low, low | step]
}

/// The local id of the edge between two corners, one of which lies on from the other along some axes.
const fn edge(a: usize, b: usize) -> u8 {
    let (low, step) = (a & b, a ^ b);
    let (x, y, z) = (low & 1, low >> 1 & 1, low >> 2 & 1);
    let id = match step {
        1 => y + 2 * z,
        2 => 4 + z + 2 * x,
        4 => 8 + x + 2 * y,
        3 => 12 + z,
        5 => 14 + y,
        6 => 16 + x,
        _ => 18,
    };
    id as u8
}

/// The edge that is counted for an edge: the right-hand one of a left and a right edge.
const fn right(edge: usize) -> usize {
    match edge {
        4..8 => edge | 2,
        8..12 => edge | 1,
        16 => 17,
        _ => edge,
    }
}

/// The triangles of a case, wound outward.
fn triangles(case: u8) -> Vec<[u8; 3]> {
    // The order of the steps, and whether it is an even one.
    const ORDERS: [([usize; 3], bool); 6] = [
        ([1, 2, 4], true),
        ([1, 4, 2], false),
        ([2, 4, 1], true),
        ([2, 1, 4], false),
        ([4, 1, 2], true),
        ([4, 2, 1], false),
    ];
    let mut found = Vec::new();
    for ([first, second, _], even) in ORDERS {
        let (one, two) = (first, first | second);
        // In an order in which the steps from the first corner to the others are right-handed.
        found.extend(cut(case, if even { [0, one, two, 7] } else { [0, two, one, 7] }));
    }
    found
}

/// The even exchanges of a tetrahedron's corners: they keep its hand.
const TURNS: [[usize; 4]; 12] = [
    [0, 1, 2, 3],
    [0, 2, 3, 1],
    [0, 3, 1, 2],
    [1, 0, 3, 2],
    [1, 2, 0, 3],
    [1, 3, 2, 0],
    [2, 0, 1, 3],
    [2, 1, 3, 0],
    [2, 3, 0, 1],
    [3, 0, 2, 1],
    [3, 1, 0, 2],
    [3, 2, 1, 0],
];

/// The triangles in one tetrahedron, by how many of its corners are inside.
fn cut(case: u8, corners: [usize; 4]) -> Vec<[u8; 3]> {
    let is_inside = |corner: &usize| case >> corner & 1 == 1;
    let n_inside = corners.iter().filter(|corner| is_inside(corner)).count();
    // The corners that are fewer come to the front.
    let n_front = n_inside.min(4 - n_inside);
    let turned = TURNS.map(|turn| turn.map(|k| corners[k])).into_iter().find(|turned| {
        let front = turned[..n_front].iter().all(|c| is_inside(c) == (n_inside < 3));
        front && turned[n_front..].iter().all(|c| is_inside(c) != (n_inside < 3))
    });
    let Some([a, b, c, d]) = turned else { return Vec::new() };
    match n_inside {
        1 => vec![[edge(a, b), edge(a, c), edge(a, d)]],
        2 => vec![[edge(a, c), edge(a, d), edge(b, d)], [edge(a, c), edge(b, d), edge(b, c)]],
        3 => vec![[edge(a, b), edge(a, d), edge(a, c)]],
        _ => Vec::new(),
    }
}
