//! The topology of the mesh is that of the trilinear interpolant.

use mcubes::pipeline::{RunOptions, SurfaceOptions};
use ndarray::Array3;

use crate::cells::{examples, moved, symmetries};
use crate::support::manifold::assert_clean;
use crate::support::oracle::{Enclosed, Field, digital};
use crate::support::random::Random;

/// Grids nearer than this to one of another topology are left out.
const MARGIN: f64 = 1e-5;

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn mesh(field: &Field) -> Mesh {
    let [nx, ny, nz] = field.dims;
    let volume = Array3::from_shape_vec((nz, ny, nx), field.values.clone()).unwrap();
    let options = RunOptions { threads: 1, ..RunOptions::default() };
    let mesh = mcubes::mesh(volume.view(), &SurfaceOptions::at(0.0), &options).unwrap();
    (mesh.vertices.to_vec(), mesh.triangles.to_vec())
}

/// What came of a number of grids.
#[derive(Debug, Default)]
struct Tally {
    held: usize,
    left_out: usize,
    digital: usize,
    digital_left_out: usize,
}

impl Tally {
    /// Holds the mesh of a grid against the count of critical points and, where `finest` is not 0,
    /// against digital pictures of up to so many points along a cell.
    fn hold(&mut self, field: &Field, margin: f64, finest: usize, what: &str) {
        let (vertices, triangles) = mesh(field);
        assert_clean(&vertices, &triangles, what);
        let count = field.count();
        if count.margin < margin {
            self.left_out += 1;
            return;
        }
        let found = Enclosed::of(&vertices, &triangles);
        assert_eq!(found.euler, 2 * count.euler, "{what}: {:?} {:?}", field.dims, field.values);
        self.held += 1;
        if finest == 0 {
            return;
        }
        match digital(field, finest) {
            None => self.digital_left_out += 1,
            Some(betti) => {
                assert_eq!(betti.euler(), count.euler, "{what}: the two ways differ");
                assert_eq!((found.solids, found.cavities), (betti.b0, betti.b2), "{what}");
                self.digital += 1;
            }
        }
    }

    /// All but a few grids were held.
    fn report(&self, what: &str) {
        self.report_but(10, what);
    }

    /// For one left out there were at least `share` held.
    fn report_but(&self, share: usize, what: &str) {
        println!("{what}: {self:?}");
        assert!(self.left_out * share <= self.held, "{what}: {self:?}");
        assert!(self.digital_left_out * 10 <= self.digital, "{what}: {self:?}");
    }
}

/// 5 × 5 × 5 values between -1 and 1.
fn noise(random: &mut Random) -> Field {
    Field { dims: [5; 3], values: (0..125).map(|_| random.between(-1.0, 1.0)).collect() }
}

/// 9 × 9 × 9 values of a few waves.
fn waves(random: &mut Random) -> Field {
    let waves: Vec<[f64; 5]> = (0..6)
        .map(|_| {
            let mut k = || random.between(-1.3, 1.3);
            [k(), k(), k(), 3.0 * k(), k()]
        })
        .collect();
    let value = |i: usize| {
        let [x, y, z] = [i % 9, i / 9 % 9, i / 81].map(|x| x as f64);
        waves.iter().map(|[a, b, c, d, s]| s * (a * x + b * y + c * z + d).sin()).sum()
    };
    Field { dims: [9; 3], values: (0..729).map(value).collect() }
}

/// One cell with the given corners inside. Heavy tails make the rare classes common.
fn cell(random: &mut Random, case: u8) -> Field {
    let power = random.between(1.0, 5.0);
    let values = (0..8).map(|i| {
        let size = random.between(0.02, 1.0).powf(power);
        if case >> i & 1 == 1 { size } else { -size }
    });
    Field { dims: [2; 3], values: values.collect() }
}

fn hold_noise(n: usize, n_digital: usize) {
    let mut random = Random::new(1);
    let mut tally = Tally::default();
    for i in 0..n {
        let finest = if i < n_digital { 64 } else { 0 };
        tally.hold(&noise(&mut random), MARGIN, finest, &format!("noise {i}"));
    }
    tally.report("noise");
}

fn hold_waves(n: usize, n_digital: usize) {
    let mut random = Random::new(2);
    let mut tally = Tally::default();
    for i in 0..n {
        let finest = if i < n_digital { 32 } else { 0 };
        tally.hold(&waves(&mut random), MARGIN, finest, &format!("waves {i}"));
    }
    tally.report("waves");
}

/// All 256 cases are all classes in all symmetries and both signs.
fn hold_cells(n: usize, n_digital: usize) {
    let mut random = Random::new(3);
    let mut tally = Tally::default();
    for i in 0..n {
        for case in 0..=255 {
            let finest = if i < n_digital { 64 } else { 0 };
            tally.hold(&cell(&mut random, case), 1e-9, finest, &format!("cell {case} {i}"));
        }
    }
    tally.report("cells");
}

/// `n` examples of each of the classes of cells, and of each row with a tunnel, in all 48 symmetries
/// and both signs: alone, and in the middle of a grid of noise.
fn hold_classes(n: usize, n_digital: usize) {
    let mut random = Random::new(5);
    let mut alone = Tally::default();
    let mut amid = Tally::default();
    let classes = examples(&mut random, n);
    assert_eq!(classes.len(), 31, "the empty cell and the 30 with a surface");
    for (class, examples) in classes {
        for (i, values) in examples.iter().enumerate() {
            for symmetry in symmetries() {
                for sign in [1.0, -1.0] {
                    let mut turned = [0.0; 8];
                    for corner in 0..8 {
                        turned[moved(symmetry, corner)] = sign * values[corner];
                    }
                    let what = format!("class {class:?} {symmetry:?} {sign}");
                    let cell = Field { dims: [2; 3], values: turned.to_vec() };
                    let finest = if i < n_digital { 64 } else { 0 };
                    alone.hold(&cell, 1e-9, finest, &what);
                    let mut noise: Vec<f64> = (0..64).map(|_| random.between(-1.0, 1.0)).collect();
                    for corner in 0..8 {
                        let [x, y, z] = [corner & 1, corner >> 1 & 1, corner >> 2];
                        noise[21 + x + 4 * y + 16 * z] = turned[corner];
                    }
                    amid.hold(&Field { dims: [4; 3], values: noise }, MARGIN, 0, &what);
                }
            }
        }
    }
    alone.report("classes, alone");
    // Many of the examples have a value near the level, which is no matter for a cell alone.
    amid.report_but(3, "classes, amid noise");
}

/// Integers from -2 to 2, so that samples lie at the iso value and faces and cells tie.
fn hold_integers(n: usize) {
    let mut random = Random::new(4);
    for i in 0..n {
        let values = (0..125).map(|_| random.below(5) as f64 - 2.0).collect();
        let (vertices, triangles) = mesh(&Field { dims: [5; 3], values });
        assert_clean(&vertices, &triangles, &format!("integers {i}"));
    }
}

#[test]
fn integer_grids_are_closed_manifold_and_stay_so_where_equal_points_are_joined() {
    hold_integers(1000);
}

#[test]
fn random_grids_have_the_interpolants_topology() {
    hold_noise(1500, 20);
}

#[test]
fn smooth_grids_have_the_interpolants_topology() {
    hold_waves(150, 0);
}

#[test]
fn cells_of_all_cases_have_the_interpolants_topology() {
    hold_cells(100, 1);
}

#[test]
fn all_classes_in_all_symmetries_and_both_signs_have_the_interpolants_topology() {
    hold_classes(1, 0);
}

/// `cargo test --release --test it oracle -- --ignored --nocapture`
#[test]
#[ignore = "the whole of what the tests above sample; minutes"]
fn twenty_thousand_grids_and_a_million_cells_have_the_interpolants_topology() {
    hold_noise(20_000, 12_000);
    hold_waves(2_000, 100);
    hold_classes(20, 1);
    hold_cells(4_000, 10);
    hold_integers(20_000);
}

/// Balls, a cavity, a ring: shapes whose topology needs no oracle.
#[test]
fn the_two_oracles_know_balls_cavities_and_rings() {
    let n = 13;
    let grid = |f: &dyn Fn([f64; 3]) -> f64| Field {
        dims: [n; 3],
        values: (0..n * n * n)
            .map(|i| f([i % n, i / n % n, i / n / n].map(|x| x as f64 - 6.03)))
            .collect(),
    };
    let norm = |p: [f64; 3]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
    let ball = grid(&|p| 4.1 - norm(p));
    let shell = grid(&|p| 1.51 - (norm(p) - 3.6).abs());
    let ring = grid(&|[x, y, z]| 1.63 - ((x.hypot(y) - 3.7).powi(2) + z * z).sqrt());
    for (field, [b0, b1, b2]) in [(ball, [1, 0, 0]), (shell, [1, 0, 1]), (ring, [1, 1, 0])] {
        assert_eq!(field.count().euler, b0 - b1 + b2);
        let betti = digital(&field, 16).unwrap();
        assert_eq!([betti.b0, betti.b1, betti.b2], [b0, b1, b2]);
        let (vertices, triangles) = mesh(&field);
        let found = Enclosed::of(&vertices, &triangles);
        assert_eq!([found.solids, found.cavities, found.euler], [b0, b2, 2 * (b0 - b1 + b2)]);
    }
}
