//! The promise in millimetres: any affine, uneven planes, and places so far off that `f32` is coarse.

use mcubes::geom::{Affine, Dims, Grid, Place, Space};
use mcubes::mesh::Position;
use mcubes::pipeline::{Method, RunOptions, SurfaceOptions};
use ndarray::Array3;
use proptest::prelude::*;

use super::surface::{volume, wild_f32};
use crate::support::manifold::{assert_clean, enclosed};

type Rows = [[f64; 3]; 3];

/// Columns are steps: turned by three angles, sheared, scaled, mirrored in half of the cases.
fn steps() -> impl Strategy<Value = Rows> {
    let angle = -3.2..3.2f64;
    let step = 0.3..3.0f64;
    let angles = (angle.clone(), angle.clone(), angle);
    (angles, (step.clone(), step.clone(), step), -0.5..0.5f64, any::<bool>()).prop_map(
        |((a, b, c), (x, y, z), shear, mirrored)| {
            let turned = times(times(turn(0, a), turn(1, b)), turn(2, c));
            let z = if mirrored { -z } else { z };
            times(turned, [[x, shear * y, 0.0], [0.0, y, shear * z], [0.0, 0.0, z]])
        },
    )
}

fn turn(axis: usize, angle: f64) -> Rows {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut rows = [[0.0; 3]; 3];
    rows[axis][axis] = 1.0;
    (rows[i][i], rows[i][j]) = (angle.cos(), -angle.sin());
    (rows[j][i], rows[j][j]) = (angle.sin(), angle.cos());
    rows
}

fn times(a: Rows, b: Rows) -> Rows {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A grid with an origin so far away on one axis that ε comes near 2^`exponent`.
fn far(dims: Dims, steps: Rows, axis: usize, exponent: f64, gaps: Option<&[f64]>) -> Grid {
    // ε is 16 u / σ, and u 2⁻²³ of the power of two below the coordinate.
    let step = (0..3).map(|c| (0..3).map(|r| steps[r][c].powi(2)).sum::<f64>().sqrt());
    let reach = 2.0f64.powf(23.0 - 4.0 + exponent) * step.fold(f64::INFINITY, f64::min);
    let mut rows = steps.map(|[x, y, z]| [x, y, z, 0.0]);
    rows[axis][3] = reach;
    let Some(gaps) = gaps else { return Grid::new(dims, Affine::from_rows(rows)) };
    let mut at = rows.map(|row| row[3]);
    let origins = (0..dims.nz()).map(|k| {
        let origin = at;
        at = [0, 1, 2].map(|a| at[a] + steps[a][2] * gaps[k % gaps.len()]);
        origin
    });
    Grid::uneven(dims, Affine::from_rows(rows), origins.collect())
}

fn check(v: &Array3<f32>, grid: &Grid, method: Method) {
    let surface = SurfaceOptions { method, ..SurfaceOptions::at(0.0) };
    let options = RunOptions { threads: 1, ..RunOptions::default() };
    let mesh = mcubes::mesh_placed(v.view(), grid, Space::Ras, &surface, &options).unwrap();
    assert_clean(&mesh.vertices, &mesh.triangles, "placed");
    if let Some(&first) = mesh.vertices.first() {
        let near: Vec<Position> =
            mesh.vertices.iter().map(|v| [0, 1, 2].map(|a| v[a] - first[a])).collect();
        assert!(enclosed(&near, &mesh.triangles) > 0.0, "wound outward");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn far_away_meshes_are_closed_and_no_two_vertices_coincide(
        v in volume(wild_f32()), steps in steps(), axis in 0..3usize, exponent in -11.0..-3.0f64,
        gaps in proptest::option::of(proptest::collection::vec(0.4..2.5f64, 1..5))
    ) {
        let (nz, ny, nx) = v.dim();
        let dims = Dims::checked(nx as i64, ny as i64, nz as i64, 4).unwrap();
        let grid = far(dims, steps, axis, exponent, gaps.as_deref());
        // Refused places are another test's.
        prop_assume!(Place::new(&grid, Space::Ras).is_ok());
        for method in [Method::Cubes, Method::Tetrahedra] {
            check(&v, &grid, method);
        }
    }
}

#[test]
fn the_worst_place_that_is_taken_keeps_vertices_apart() {
    let steps = times(turn(0, 0.7), turn(2, 0.4)).map(|row| row.map(|x| 1.001 * x));
    let dims = Dims::checked(24, 24, 24, 4).unwrap();
    let mut random = crate::support::random::Random::new(3);
    let noise = Array3::from_shape_fn((24, 24, 24), |_| random.below(5) as f32 - 2.0);
    for axis in 0..3 {
        // Just below 2¹⁷ millimetres the spacing is 2⁻⁷, so that ε is at its limit of 1/8.
        let mut rows = steps.map(|[x, y, z]| [x, y, z, 0.0]);
        rows[axis][3] = 131_000.0;
        let grid = Grid::new(dims, Affine::from_rows(rows));
        let epsilon = Place::new(&grid, Space::Ras).unwrap().epsilon();
        assert!((0.124..=0.125).contains(&epsilon), "{epsilon}");
        for method in [Method::Cubes, Method::Tetrahedra] {
            check(&noise, &grid, method);
        }
    }
}
