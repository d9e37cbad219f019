//! The kernel on volumes in memory: items are triangles, bytes are those of the samples, two each.
//!
//! ```text
//! cargo bench --bench kernel            # 128, 256 and 512
//! cargo bench --bench kernel -- 128     # the smallest alone
//! ```
//!
//! Each call makes its own mesh. What other programs take is measured by `benches/peers`.

#![allow(clippy::expect_used, reason = "a bench ends where it cannot measure")]

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use mcubes::pipeline::{RunOptions, SurfaceOptions};
use ndarray::Array3;

const SIZES: [usize; 3] = [128, 256, 512];

fn main() {
    divan::main();
}

/// A head as a CT sees it: skin, skull and noise, in Hounsfield units.
fn head(n: usize) -> Array3<i16> {
    let mut state = 1_u64;
    Array3::from_shape_fn((n, n, n), |(z, y, x)| {
        let d = |i: usize, half: f64| ((2.0 * i as f64 / n as f64 - 1.0) / half).powi(2);
        let r = (d(x, 0.55) + d(y, 0.67) + d(z, 0.65)).sqrt();
        // Shells that fade over two samples.
        let edge = |at: f64| ((at - r) * 0.3 * n as f64 + 0.5).clamp(0.0, 1.0);
        let value = -1000.0 + 1040.0 * edge(1.0) + 860.0 * (edge(0.94) - edge(0.86));
        // Noise by Marsaglia's xorshift; the mean of four bytes is near enough to normal.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let noise: f64 = state.to_le_bytes()[..4].iter().map(|&b| f64::from(b) - 127.5).sum();
        (value + 0.24 * noise) as i16
    })
}

/// A gyroid with a period of 56 samples.
fn gyroid(n: usize) -> Array3<i16> {
    let angle = |i: usize| i as f64 * std::f64::consts::TAU / 56.0;
    let waves: Vec<_> = (0..n).map(|i| angle(i).sin_cos()).collect();
    Array3::from_shape_fn((n, n, n), |(z, y, x)| {
        let [(sx, cx), (sy, cy), (sz, cz)] = [waves[x], waves[y], waves[z]];
        (1000.0 * (sx * cy + sy * cz + sz * cx)) as i16
    })
}

/// Air, with one small block.
fn empty(n: usize) -> Array3<i16> {
    let is_block = |i: usize| i.abs_diff(n / 2) < 3;
    Array3::from_shape_fn((n, n, n), |(z, y, x)| {
        if is_block(x) && is_block(y) && is_block(z) { 1000 } else { -1000 }
    })
}

fn measure(
    bencher: Bencher<'_, '_>,
    volume: &Array3<i16>,
    surface: SurfaceOptions,
    threads: usize,
) {
    let options = RunOptions { threads, ..RunOptions::default() };
    let mesh = || mcubes::mesh(volume.view(), &surface, &options).expect("a volume that fits");
    let triangles = mesh().triangles.len();
    bencher
        .counter(ItemsCount::new(triangles))
        .counter(BytesCount::new(2 * volume.len()))
        .bench_local(|| {
            let mesh = mesh();
            assert_eq!(mesh.triangles.len(), triangles);
            mesh
        });
}

#[divan::bench(args = SIZES, sample_count = 7, sample_size = 1)]
fn head_one_thread(bencher: Bencher<'_, '_>, n: usize) {
    measure(bencher, &head(n), SurfaceOptions::at(300.0), 1);
}

#[divan::bench(args = SIZES, sample_count = 7, sample_size = 1)]
fn head_with_normals_one_thread(bencher: Bencher<'_, '_>, n: usize) {
    let surface = SurfaceOptions { normals: true, ..SurfaceOptions::at(300.0) };
    measure(bencher, &head(n), surface, 1);
}

#[divan::bench(args = SIZES, sample_count = 7, sample_size = 1)]
fn head_two_threads(bencher: Bencher<'_, '_>, n: usize) {
    measure(bencher, &head(n), SurfaceOptions::at(300.0), 2);
}

#[divan::bench(args = SIZES, sample_count = 7, sample_size = 1)]
fn gyroid_one_thread(bencher: Bencher<'_, '_>, n: usize) {
    measure(bencher, &gyroid(n), SurfaceOptions::at(0.5), 1);
}

#[divan::bench(args = SIZES, sample_count = 7, sample_size = 1)]
fn empty_one_thread(bencher: Bencher<'_, '_>, n: usize) {
    measure(bencher, &empty(n), SurfaceOptions::at(300.0), 1);
}
