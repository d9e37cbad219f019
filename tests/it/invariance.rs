//! What a mesh must not hang on: the order and direction of a volume's axes, and where its zero is.

use std::collections::HashMap;

use mcubes::geom::{Affine, Dims, Grid, Space};
use mcubes::kernel::Classify;
use mcubes::mesh::Position;
use mcubes::pipeline::{Method, RunOptions, Side, Surface, SurfaceOptions};
use ndarray::{Array3, ArrayView3, Axis};
use proptest::prelude::*;

use super::surface::volume;
use crate::support::manifold::{assert_clean, enclosed};

/// Another way to number the same samples: which axis each of i, j, k was, and whether it is walked
/// backwards.
#[derive(Clone, Copy, Debug)]
struct Turn {
    axes: [usize; 3],
    backwards: [bool; 3],
}

impl Turn {
    fn all() -> impl Iterator<Item = Self> {
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        orders.into_iter().flat_map(|axes| {
            (0..8).map(move |bits| Self { axes, backwards: [1, 2, 4].map(|bit| bits & bit != 0) })
        })
    }

    /// Kuhn's split of a cell into tetrahedra is around the diagonal from its lowest corner: only
    /// what keeps that diagonal keeps the split.
    fn keeps_diagonals(self) -> bool {
        self.backwards == [self.backwards[0]; 3]
    }

    fn view(self, v: &Array3<f32>) -> ArrayView3<'_, f32> {
        // The array's axes are k, j, i.
        let mut view = v.view().permuted_axes([2, 1, 0].map(|axis| 2 - self.axes[axis]));
        for (axis, _) in self.backwards.iter().enumerate().filter(|(_, is)| **is) {
            view.invert_axis(Axis(2 - axis));
        }
        view
    }

    /// The grid on which the turned volume's samples lie where they were.
    fn grid(self, grid: &Grid) -> Grid {
        let old = grid.dims.to_array();
        let [nx, ny, nz] = self.axes.map(|axis| old[axis] as i64);
        let mut origin = grid.affine.column(3);
        let [i, j, k] = [0, 1, 2].map(|axis| {
            let step = grid.affine.column(self.axes[axis]);
            if !self.backwards[axis] {
                return step;
            }
            let last = (old[self.axes[axis]] - 1) as f64;
            origin = [0, 1, 2].map(|x| origin[x] + last * step[x]);
            step.map(|x| -x)
        });
        let dims = Dims::checked(nx, ny, nz, 4).unwrap();
        Grid::new(dims, Affine::from_columns(i, j, k, origin))
    }
}

/// A few hills and valleys of some samples' width, and a level that the highest hill reaches.
fn hills() -> impl Strategy<Value = (Array3<f32>, f64)> {
    let hill = (prop::array::uniform3(0.0..10.0f64), 0.5..4.0f64, -1.0..1.0f64);
    let dims = prop::array::uniform3(4..11usize);
    (dims, prop::collection::vec(hill, 1..24), 0.05..0.9f64).prop_map(|(dims, mut hills, part)| {
        hills[0].2 = 1.0;
        let value = |at: [f64; 3]| {
            let of = |(centre, width, height): &([f64; 3], f64, f64)| {
                let square: f64 = (0..3).map(|a| (at[a] - centre[a]).powi(2)).sum();
                height * (-square / (2.0 * width * width)).exp()
            };
            hills.iter().map(of).sum::<f64>() as f32
        };
        let volume = Array3::from_shape_fn(dims, |(z, y, x)| value([x, y, z].map(|n| n as f64)));
        let highest = f64::from(volume.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        (volume, part * highest)
    })
}

/// Whether points of single precision are one point, rounded twice.
fn is_same(p: Position, q: Position) -> bool {
    (0..3).all(|a| {
        let (x, y) = (f64::from(p[a]), f64::from(q[a]));
        let larger = p[a].abs().max(q[a].abs());
        // Each is off by half of this at most; the rest is for the arithmetic before, near zero.
        (x - y).abs() <= f64::from(larger.next_up()) - f64::from(larger) + 1e-12
    })
}

/// The first of the points that is none of the others, to within their roundings.
fn missing(points: &[Position], others: &[Position]) -> Option<Position> {
    const SIZE: f64 = 0.01;
    let place = |p: Position| p.map(|x| (f64::from(x) / SIZE).floor() as i64);
    let mut boxes: HashMap<[i64; 3], Vec<Position>> = HashMap::new();
    for &p in others {
        boxes.entry(place(p)).or_default().push(p);
    }
    points.iter().copied().find(|&p| {
        let [x, y, z] = place(p);
        let near = (0..27).map(|n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]);
        !near.filter_map(|at| boxes.get(&at)).flatten().any(|&q| is_same(p, q))
    })
}

const AFFINE: Affine = Affine::from_rows([
    [0.71, -0.29, 0.83, -11.3],
    [0.35, 0.88, -0.41, 4.7],
    [-0.13, 0.37, 2.09, 1.1],
]);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_order_and_direction_of_the_axes_gives_the_same_points((v, iso) in hills()) {
        prop_assume!(iso > 0.0);
        let (nz, ny, nx) = v.dim();
        let dims = Dims::checked(nx as i64, ny as i64, nz as i64, 4).unwrap();
        let grid = Grid::new(dims, AFFINE);
        let options = RunOptions { threads: 1, ..RunOptions::default() };
        for method in [Method::Cubes, Method::Tetrahedra] {
            let surface = SurfaceOptions { method, ..SurfaceOptions::at(iso) };
            let mesh = |view: ArrayView3<'_, f32>, grid: &Grid| {
                mcubes::mesh_placed(view, grid, Space::Ras, &surface, &options).unwrap()
            };
            let expected = mesh(v.view(), &grid);
            for turn in Turn::all().filter(|t| method == Method::Cubes || t.keeps_diagonals()) {
                let found = mesh(turn.view(&v), &turn.grid(&grid));
                let (points, triangles) = (&found.vertices[..], &found.triangles[..]);
                assert_clean(points, triangles, &format!("{turn:?}"));
                prop_assert!(enclosed(points, triangles) > 0.0, "{turn:?}: outward");
                prop_assert_eq!(points.len(), expected.vertices.len(), "{:?}", turn);
                prop_assert_eq!(triangles.len(), expected.triangles.len(), "{:?}", turn);
                prop_assert_eq!(missing(points, &expected.vertices), None, "{:?}", turn);
                prop_assert_eq!(missing(&expected.vertices, points), None, "{:?}", turn);
            }
        }
    }
}

/// Bits of positions and normals, and the triangles.
type Bits = (Vec<[u32; 3]>, Vec<[u32; 3]>, Vec<[u32; 3]>);

fn bits<T: Classify>(v: &Array3<T>, surface: &SurfaceOptions) -> Bits {
    let options = RunOptions { threads: 1, ..RunOptions::default() };
    let mesh = mcubes::mesh(v.view(), surface, &options).unwrap();
    let Surface { vertices, normals, triangles } = mesh;
    let of = |points: &[[f32; 3]]| points.iter().map(|p| p.map(f32::to_bits)).collect();
    (of(&vertices), of(&normals.unwrap()), triangles.to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn samples_and_iso_value_moved_by_one_number_give_the_same_bytes(
        v in volume(prop_oneof![-2i16..=2, -200i16..=200]), halves in -300..=300i32,
        by in 200..30_000i16, (tetrahedra, below, open) in any::<(bool, bool, bool)>()
    ) {
        // Whole samples and halves: nothing is rounded on the way to a difference.
        let method = if tetrahedra { Method::Tetrahedra } else { Method::Cubes };
        let side = if below { Side::Below } else { Side::AtLeast };
        let at = |moved: i16| {
            let iso = f64::from(halves) / 2.0 + f64::from(moved);
            SurfaceOptions { method, side, open, normals: true, ..SurfaceOptions::at(iso) }
        };
        let expected = bits(&v, &at(0));
        prop_assert_eq!(&bits(&v.mapv(|x| x + by), &at(by)), &expected, "i16");
        prop_assert_eq!(&bits(&v.mapv(|x| x - by), &at(-by)), &expected, "i16, below zero");
        prop_assert_eq!(&bits(&v.mapv(|x| (x + by) as u16), &at(by)), &expected, "u16");
        prop_assert_eq!(&bits(&v.mapv(|x| i32::from(x - by)), &at(-by)), &expected, "i32");
        prop_assert_eq!(&bits(&v.mapv(|x| f32::from(x - by)), &at(-by)), &expected, "f32");
        prop_assert_eq!(&bits(&v.mapv(|x| f64::from(x + by)), &at(by)), &expected, "f64");
    }
}
