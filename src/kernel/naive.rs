//! Bits, crossings and cells against loops over samples, for every width about the ends of words.

use super::bits::BitPlane;
use super::cpu::Detected;
use super::key::Threshold;
use super::layer::{Cells, Counts, Layer, UNSETTLED};
use super::region::Region;
use super::{Cpu, simd};

/// Samples -2 to 2, the same on every machine; now and then whole rows of one of them.
fn samples(nx: usize, ny: usize, seed: u64) -> Vec<i16> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = |n: u64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let mut out = Vec::new();
    for _ in 0..ny {
        let whole = (next(4) == 0).then(|| next(5));
        out.extend((0..nx).map(|_| whole.unwrap_or_else(|| next(5)) as i16 - 2));
    }
    out
}

/// Whether sample (i, j) is inside; the border is outside.
fn is_inside(samples: &[i16], (nx, ny): (usize, usize), i: i64, j: i64) -> bool {
    let within = (0..nx as i64).contains(&i) && (0..ny as i64).contains(&j);
    within && samples[j as usize * nx + i as usize] >= 1
}

/// Numbers of crossed X, Y and Z edges, and the active cells by (row, column) with their cases.
type Found = ([u32; 3], Vec<(u32, u32, u8)>);

fn expected(planes: [&[i16]; 2], dims: (usize, usize), open: bool) -> Found {
    let (nx, ny) = (dims.0 as i64, dims.1 as i64);
    let at = |z: usize, i, j| is_inside(planes[z], dims, i, j);
    let counts = |low: i64, n: i64| if open { low.max(0)..n - 1 } else { low..n };
    let mut edges = [0; 3];
    for j in 0..ny {
        edges[0] += counts(-1, nx).filter(|&i| at(1, i, j) != at(1, i + 1, j)).count() as u32;
    }
    for j in counts(-1, ny) {
        edges[1] += (0..nx).filter(|&i| at(1, i, j) != at(1, i, j + 1)).count() as u32;
    }
    for j in 0..ny {
        edges[2] += (0..nx).filter(|&i| at(0, i, j) != at(1, i, j)).count() as u32;
    }
    let mut cells = Vec::new();
    for j in counts(-1, ny) {
        for i in counts(-1, nx) {
            let corner = |c: i64| at((c >> 2) as usize, i + (c & 1), j + (c >> 1 & 1));
            let case = (0..8).fold(0u8, |case, c| case | u8::from(corner(c)) << c);
            if case != 0 && case != 255 {
                cells.push(((j + 1) as u32, (i + 1) as u32, case));
            }
        }
    }
    (edges, cells)
}

#[test]
fn bits_crossings_and_cells_are_those_of_loops_over_samples() {
    let mut counts: Counts = [1; 256];
    // Every third case is taken for one that must be settled, so that those are noted as well.
    counts.iter_mut().step_by(3).for_each(|count| *count = UNSETTLED);
    let widths = (1..=130).chain([191, 192, 193, 511, 512, 513]);
    for nx in widths {
        for (ny, open) in [(1, false), (2, true), (3, false), (4, true)] {
            let dims = (nx, ny);
            let region = Region { dims, open };
            let seed = (nx * 8 + ny) as u64;
            let planes = [samples(nx, ny, seed), samples(nx, ny, seed + 4000)];
            let (edges, cells) = expected([&planes[0], &planes[1]], dims, open);
            for cpu in [Cpu::Scalar, Cpu::Sse2, Cpu::Avx2, Cpu::Avx512].map(Detected::at_most) {
                let what = format!("{nx} x {ny}, open {open}, {cpu:?}");
                let bits = [0, 1].map(|z| {
                    let mut bits = BitPlane::new(nx, ny);
                    let threshold = Threshold { flip: 0, at: 1 };
                    simd::i16::fill(cpu, &planes[z], threshold, region, &mut bits);
                    bits
                });
                let mut layer = Layer::default();
                let among = Cells { region, in_border: false };
                simd::fill_layer(cpu, &counts, [&bits[0], &bits[1]], dims, among, &mut layer);
                assert_eq!([bits[1].n_x(), bits[1].n_y(), layer.n_z()], edges, "{what}");
                let cases: Vec<u8> = cells.iter().map(|cell| cell.2).collect();
                assert_eq!(layer.cases(), cases, "{what}");
                let unsettled = |case: u8| counts[usize::from(case)] == UNSETTLED;
                let noted: Vec<_> = cells.iter().filter(|cell| unsettled(cell.2)).collect();
                assert_eq!(layer.unsettled.len(), noted.len(), "{what}");
                for (found, &&(row, c, case)) in layer.unsettled.iter().zip(&noted) {
                    let nth = cells.iter().filter(|cell| cell.0 == row && cell.1 < c).count();
                    assert_eq!((found.c, found.nth as usize, found.case), (c, nth, case), "{what}");
                }
                assert_eq!(layer.n_plain_triangles, (cells.len() - noted.len()) as u64, "{what}");
            }
        }
    }
}
