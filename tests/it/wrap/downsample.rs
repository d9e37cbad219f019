//! `downsample`: means of blocks, against a plain sum over each block's samples.

use mcubes::error::{Failure, Kind};
use mcubes::geom::{Affine, Grid};
use mcubes::source::{AnyPlanes, downsample};
use mcubes::volume::{Padding, Sample};
use ndarray::{Array3, s};

use super::sources::{Log, WAYS, Way, dims_of, planes, read, volume, way};

/// The mean of what counts in each block.
fn plain<T: Sample>(array: &Array3<T>, n: [usize; 3], counts: impl Fn(f64) -> bool) -> Array3<f64> {
    let (nz, ny, nx) = array.dim();
    let [ni, nj, nk] = n;
    let shape = (nz.div_ceil(nk), ny.div_ceil(nj), nx.div_ceil(ni));
    Array3::from_shape_fn(shape, |(k, j, i)| {
        let part = array.slice(s![
            k * nk..nz.min((k + 1) * nk),
            j * nj..ny.min((j + 1) * nj),
            i * ni..nx.min((i + 1) * ni)
        ]);
        let kept: Vec<f64> = part.iter().map(|x| x.to_f64()).filter(|&x| counts(x)).collect();
        kept.iter().sum::<f64>() / kept.len() as f64
    })
}

fn near(a: &Array3<f64>, b: &Array3<f64>) -> bool {
    a.dim() == b.dim()
        && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12 || a.is_nan() && b.is_nan())
}

#[test]
fn blocks_are_means_short_ones_of_what_they_have() {
    let array =
        Array3::from_shape_fn((7, 6, 9), |(k, j, i)| ((k * 91 + j * 37 + i * i) % 251) as u8);
    for n in [[2, 2, 2], [3, 1, 4], [1, 1, 7], [100, 100, 100], [4, 5, 1]] {
        for which in WAYS {
            let log = Log::default();
            let whole = AnyPlanes::U8(planes(&array, which, &log));
            let coarse = downsample(volume::<u8>(dims_of(&array), whole), n).unwrap();
            assert_eq!(way(&coarse) == Way::Ordered, which == Way::Ordered);
            assert!(near(&read(coarse), &plain(&array, n, |_| true)), "{which:?} {n:?}");
        }
    }
}

#[test]
fn sums_of_the_largest_numbers_are_exact() {
    // Down a column, the most samples that 32 bits can add up, and a row more than those.
    let log = Log::default();
    for (nk, nj) in [(128, 256), (128, 257)] {
        for x in [i16::MIN, i16::MAX] {
            let array = Array3::from_elem((nk, nj, 2), x);
            let whole = AnyPlanes::I16(planes(&array, Way::Resident, &log));
            let coarse = downsample(volume::<i16>(dims_of(&array), whole), [2, nj, nk]).unwrap();
            assert_eq!(read(coarse), Array3::from_elem((1, 1, 1), f64::from(x)));
        }
        let array = Array3::from_elem((nk, nj, 2), u16::MAX);
        let whole = AnyPlanes::U16(planes(&array, Way::Resident, &log));
        let coarse = downsample(volume::<u16>(dims_of(&array), whole), [1, nj, nk]).unwrap();
        assert_eq!(read(coarse), Array3::from_elem((1, 1, 2), 65535.0));
    }
}

#[test]
fn nan_and_padding_are_left_out_and_a_block_of_nothing_else_is_nan() {
    let mut array =
        Array3::from_shape_fn((4, 4, 6), |(k, j, i)| (k * 50 + j * 10 + i) as f32 * 0.37 - 20.0);
    array.slice_mut(s![0..2, 0..2, 0..2]).fill(f32::NAN);
    array[[0, 0, 0]] = -3000.0;
    array[[3, 2, 4]] = f32::NAN;
    array[[2, 3, 5]] = -2000.5;
    for which in WAYS {
        let log = Log::default();
        let mut whole = volume::<f32>(dims_of(&array), AnyPlanes::F32(planes(&array, which, &log)));
        whole.meta.padding = Some(Padding { low: -3000.0, high: -2000.0 });
        let coarse = downsample(whole, [2, 2, 2]).unwrap();
        assert_eq!(coarse.meta.padding, None);
        let found = read(coarse);
        assert!(found[[0, 0, 0]].is_nan() && found[[1, 1, 2]].is_finite());
        let expected = plain(&array, [2, 2, 2], |x| !x.is_nan() && x > -2000.0);
        assert!(near(&found, &expected), "{which:?}");
    }
}

#[test]
fn uneven_planes_lie_at_the_mean_of_their_block() {
    let array = Array3::<u8>::zeros((5, 2, 2));
    let log = Log::default();
    let whole = AnyPlanes::U8(planes(&array, Way::Resident, &log));
    let mut whole = volume::<u8>(dims_of(&array), whole);
    let origins = [0.0, 1.0, 3.0, 4.0, 10.0].map(|z| [0.0, 0.0, z]).to_vec();
    whole.meta.grid = Grid::uneven(dims_of(&array), Affine::IDENTITY, origins);
    let coarse = downsample(whole, [1, 1, 2]).unwrap();
    let heights: Vec<f64> = (0..3).map(|k| coarse.meta.grid.plane_origin(k)[2]).collect();
    assert_eq!(heights, [0.5, 3.5, 10.0]);
    assert_eq!(coarse.meta.gaps_mm, Some(vec![3.0, 6.5]));
}

#[test]
fn blocks_of_nothing_are_refused_and_blocks_of_one_change_nothing() {
    let array = Array3::<u8>::zeros((5, 2, 2));
    let log = Log::default();
    let whole =
        || volume::<u8>(dims_of(&array), AnyPlanes::U8(planes(&array, Way::Resident, &log)));
    let refused = downsample(whole(), [2, 0, 2]).err().unwrap();
    assert_eq!(refused.kind(), Kind::BadDims);
    assert_eq!(refused.to_string(), "blocks of 2 x 0 x 2 samples: each must be at least 1");
    assert!(matches!(downsample(whole(), [1; 3]).unwrap().planes, AnyPlanes::U8(_)));
}
