//! Draws cells as `docs/topology.md` shows them: an example of each class,
//! `cargo run --example cells > docs/cells.svg`, or some cells cut into tetrahedra,
//! `cargo run --example cells tetrahedra > docs/tetrahedra.svg`.

use mcubes::kernel::cube::edge_corners;
use mcubes::kernel::{
    CellSurface, N_TETRA_EDGES, Tables, TetraTables, crossing, edge_ends, settle,
};

type Point = [f64; 3];

/// Name, case, and the bits of its ambiguous faces that join, or a tunnel.
const CLASSES: [(&str, u8, Option<u16>); 30] = [
    ("1", 1, Some(0)),
    ("2", 3, Some(0)),
    ("3.1", 6, Some(0)),
    ("3.2", 6, Some(1)),
    ("4.1", 24, Some(0)),
    ("4.2", 24, None),
    ("5", 7, Some(0)),
    ("6.1.1", 25, Some(0)),
    ("6.1.2", 25, None),
    ("6.2", 25, Some(1)),
    ("7.1", 22, Some(0)),
    ("7.2", 22, Some(1)),
    ("7.3", 22, Some(3)),
    ("7.4.1", 22, Some(7)),
    ("7.4.2", 22, None),
    ("8", 15, Some(0)),
    ("9", 23, Some(0)),
    ("10.1.1", 60, Some(0)),
    ("10.1.2", 60, None),
    ("10.2", 60, Some(1)),
    ("11, 14", 27, Some(0)),
    ("12.1.1", 30, Some(0)),
    ("12.1.2", 30, None),
    ("12.2", 30, Some(1)),
    ("13.1", 105, Some(0)),
    ("13.2", 105, Some(1)),
    ("13.3", 105, Some(5)),
    ("13.4", 105, Some(21)),
    ("13.5.1", 105, Some(22)),
    ("13.5.2", 105, None),
];

const EPSILON: f64 = 1.0 / 1024.0;
/// Cases drawn with their tetrahedra: triangles, a quadrilateral, and what cubes find ambiguous.
const CUT: [(&str, u8); 6] =
    [("1", 1), ("2", 3), ("3", 6), ("4", 24), ("4, along the diagonal", 129), ("13", 105)];

fn main() {
    if std::env::args().nth(1).as_deref() == Some("tetrahedra") {
        page(&CUT.map(|(name, case)| (name, drawing_of_tetrahedra(case))));
    } else {
        let drawing = |case, faces| example(case, faces).map(|(v, s)| drawing(case, &v, &s));
        page(&CLASSES.map(|(name, case, faces)| (name, drawing(case, faces).unwrap_or_default())));
    }
}

/// What is drawn of one cell.
#[derive(Default)]
struct Drawing {
    case: u8,
    triangles: Vec<[Point; 3]>,
    /// Vertices inside the cell.
    points: Vec<Point>,
    /// Diagonals of the split.
    diagonals: Vec<[Point; 2]>,
}

fn page(drawings: &[(&str, Drawing)]) {
    let (columns, size) = (6, 150.0);
    let height = drawings.len().div_ceil(columns) as f64 * (size + 20.0);
    println!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {} {height}" font-family="sans-serif" font-size="13" stroke-linejoin="round">"#,
        columns as f64 * size
    );
    println!(r##"<rect width="100%" height="100%" fill="#ffffff"/>"##);
    for (n, (name, drawing)) in drawings.iter().enumerate() {
        let (x, y) = ((n % columns) as f64 * size, (n / columns) as f64 * (size + 20.0));
        println!(r#"<g transform="translate({} {})">"#, x + size / 2.0, y + size / 2.0 + 12.0);
        println!(r#"<text x="{}" y="{}">{name}</text>"#, 8.0 - size / 2.0, 6.0 - size / 2.0);
        drawing.draw(size * 0.58);
        println!("</g>");
    }
    println!("</svg>");
}

/// Among many random cells of a class, the one whose vertices keep furthest from the corners.
fn example(case: u8, faces: Option<u16>) -> Option<([f64; 8], CellSurface)> {
    let tables = Tables::get(false);
    let mut random = 1u64;
    let mut best = None;
    let mut most = 0.0;
    for _ in 0..400_000 {
        let values: [f64; 8] = std::array::from_fn(|corner| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(99);
            let size = 0.03 + ((random >> 40) as f64 / (1u64 << 24) as f64).powi(2);
            if case >> corner & 1 == 1 { size } else { -size }
        });
        let t = |edge: usize| parameter(&values, edge);
        let surface = settle(tables, case, &values, t, EPSILON);
        let is_wanted = match faces {
            Some(bits) => surface.row == tables.first_row[usize::from(case)] + bits,
            None => usize::from(surface.row) >= Tables::N_PLAIN_ROWS,
        };
        if is_wanted {
            let crossed = (0..12).filter(|&edge| mcubes::kernel::cube::is_crossed(case, edge));
            let on_edges = crossed.map(t).map(|t| t.min(1.0 - t)).fold(1.0, f64::min);
            let extra = surface.extra[..surface.n_extra.into()].as_flattened();
            let inside = extra.iter().map(|x| x.min(1.0 - x)).fold(1.0, f64::min);
            if on_edges.min(inside) > most {
                most = on_edges.min(inside);
                best = Some((values, surface));
            }
        }
    }
    best
}

fn parameter(values: &[f64; 8], edge: usize) -> f64 {
    let [low, high] = edge_corners(edge);
    crossing(values[low], values[high], 0.0, EPSILON)
}

fn at_corner(corner: usize) -> Point {
    [0, 1, 2].map(|axis| (corner >> axis & 1) as f64)
}

/// Right, down and towards the eye, in units of the cell, from its middle.
fn seen([x, y, z]: Point) -> Point {
    let [x, y, z] = [x - 0.5, y - 0.5, z - 0.5];
    let ((sin, cos), (up_sin, up_cos)) = (0.42f64.sin_cos(), 0.33f64.sin_cos());
    let (right, depth) = (x * cos + y * sin, y * cos - x * sin);
    [right, -(z * up_cos + depth * up_sin), z * up_sin - depth * up_cos]
}

fn drawing(case: u8, values: &[f64; 8], surface: &CellSurface) -> Drawing {
    let row = &Tables::get(false).rows[usize::from(surface.row)];
    let place = |id| surface.point(id, |edge| parameter(values, edge));
    Drawing {
        case,
        triangles: row.triangles().map(|ids| ids.map(place)).collect(),
        points: surface.extra[..surface.n_extra.into()].to_vec(),
        diagonals: Vec::new(),
    }
}

/// All vertices in the middle of their edges.
fn drawing_of_tetrahedra(case: u8) -> Drawing {
    let tables = TetraTables::get(false);
    let place = |id: u8| {
        let [a, b] = edge_ends(id.into()).map(at_corner);
        [0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis]))
    };
    let corners = tables.ids[usize::from(case)].as_flattened();
    Drawing {
        case,
        triangles: triangles(corners, tables.n_triangles[usize::from(case)], place),
        points: Vec::new(),
        diagonals: (12..N_TETRA_EDGES).map(|id| edge_ends(id).map(at_corner)).collect(),
    }
}

fn triangles(ids: &[u8], n: u8, place: impl Fn(u8) -> Point) -> Vec<[Point; 3]> {
    let ids = ids.chunks(3).take(n.into());
    ids.map(|ids| [place(ids[0]), place(ids[1]), place(ids[2])]).collect()
}

impl Drawing {
    fn draw(&self, scale: f64) {
        let on_paper = |p: Point| {
            let [right, down, _] = seen(p);
            format!("{:.1},{:.1}", right * scale, down * scale)
        };
        let edges = |behind: bool| {
            for edge in 0..12 {
                let ends = edge_corners(edge).map(at_corner);
                // The corner furthest from the eye.
                let is_behind = ends.contains(&[0.0, 1.0, 0.0]);
                if is_behind == behind {
                    let [a, b] = ends.map(on_paper);
                    let colour = if behind { "#c0c0c0" } else { "#707070" };
                    println!(r#"<path d="M{a}L{b}" stroke="{colour}" fill="none"/>"#);
                }
            }
        };
        edges(true);
        for ends in &self.diagonals {
            let [a, b] = ends.map(on_paper);
            println!(
                r##"<path d="M{a}L{b}" stroke="#a0b0a0" stroke-dasharray="3 2" fill="none"/>"##
            );
        }
        let mut triangles = self.triangles.clone();
        let depth = |t: &[Point; 3]| t.iter().map(|&p| seen(p)[2]).sum::<f64>();
        triangles.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        for triangle in triangles {
            let [a, b, c] = triangle.map(seen);
            let (u, v) =
                ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
            let normal =
                [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            // Down is positive on paper, so that a triangle seen from outside turns the other way.
            let facing = -normal[2] / length;
            let light = 0.55 + 0.4 * facing.abs();
            let [r, g, b] =
                if facing > 0.0 { [110.0, 160.0, 230.0] } else { [240.0, 180.0, 110.0] };
            let [r, g, b] = [r, g, b].map(|c: f64| (c * light) as u8);
            let [p, q, s] = triangle.map(on_paper);
            println!(
                r##"<path d="M{p}L{q}L{s}Z" fill="rgb({r},{g},{b})" fill-opacity="0.86" stroke="#203040" stroke-width="0.7"/>"##
            );
        }
        edges(false);
        for &point in &self.points {
            let [x, y, _] = seen(point);
            println!(
                r##"<circle cx="{:.1}" cy="{:.1}" r="2.6" fill="#c02020"/>"##,
                x * scale,
                y * scale
            );
        }
        for corner in (0..8).filter(|corner| self.case >> corner & 1 == 1) {
            let [x, y, _] = seen(at_corner(corner));
            println!(
                r##"<circle cx="{:.1}" cy="{:.1}" r="4" fill="#101010"/>"##,
                x * scale,
                y * scale
            );
        }
    }
}
