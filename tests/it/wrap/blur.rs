//! `blur`: a Gaussian, against scipy away from the border and against the plain triple sum
//! everywhere.

use mcubes::error::{Failure, Kind};
use mcubes::geom::{Affine, Dims, Grid};
use mcubes::source::{AnyPlanes, Planes, Volume, blur, crop, downsample};
use mcubes::volume::Padding;
use ndarray::{Array2, Array3, s};

use super::sources::{Log, WAYS, Way, affine, dims_of, planes, read, same, volume, way};

const SIGMA_MM: f64 = 1.5;

fn array() -> Array3<i16> {
    Array3::from_shape_fn((10, 14, 20), |(k, j, i)| {
        let sum = i * 7 + j * 13 + k * 29 + i * j * 3 + j * k * 5 + k * i * 11;
        (sum % 101) as i16 - 50
    })
}

/// scipy 1.17.1: `gaussian_filter(a.astype(float), 1.5 / spacing, truncate=4.0)` of [`array`], with
/// the spacing of the oblique affine, √(0.25² + 3²), 2 and 1 along z, y, x; none of these samples
/// is within the filter's reach of a border.
const SCIPY: [([usize; 3], f64); 8] = [
    ([2, 3, 6], -0.933_019_033_161_176_7),
    ([7, 10, 13], -3.321_633_798_714_705_3),
    ([4, 5, 9], -2.501_345_899_164_246_8),
    ([5, 8, 10], 6.407_585_782_966_634),
    ([3, 7, 12], -0.964_439_266_181_496_4),
    ([6, 9, 7], 0.299_051_551_308_159_7),
    ([2, 10, 13], -1.533_138_427_751_518_3),
    ([5, 5, 8], -1.425_407_327_133_642),
];

/// The weighted mean of every sample that counts within reach, summed as the definition says.
fn plain(array: &Array3<f64>, sigma: [f64; 3], counts: impl Fn(f64) -> bool) -> Array3<f64> {
    let reach = sigma.map(|s| (4.0 * s + 0.5) as usize);
    Array3::from_shape_fn(array.dim(), |(k, j, i)| {
        if !counts(array[[k, j, i]]) {
            return f64::NAN;
        }
        let (mut sum, mut weights) = (0.0, 0.0);
        for ((k2, j2, i2), &x) in array.indexed_iter() {
            let far = [i.abs_diff(i2), j.abs_diff(j2), k.abs_diff(k2)];
            if (0..3).all(|a| far[a] <= reach[a]) && counts(x) {
                let power: f64 = (0..3).map(|a| (far[a] as f64 / sigma[a]).powi(2)).sum();
                sum += (-0.5 * power).exp() * x;
                weights += (-0.5 * power).exp();
            }
        }
        sum / weights
    })
}

fn assert_near(found: &Array3<f64>, expected: &Array3<f64>) {
    for ((place, a), b) in found.indexed_iter().zip(expected) {
        assert!((a - b).abs() < 1e-10 || a.is_nan() && b.is_nan(), "{place:?}: {a}, not {b}");
    }
}

fn sigma(affine: Affine) -> [f64; 3] {
    affine.spacing().map(|step| SIGMA_MM / step)
}

#[test]
fn agrees_with_scipy_away_from_the_border() {
    let array = array();
    for which in WAYS {
        let log = Log::default();
        let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
        let blurred = blur(whole, SIGMA_MM).unwrap();
        assert_eq!(way(&blurred) == Way::Ordered, which == Way::Ordered);
        let found = read(blurred);
        for (place, expected) in SCIPY {
            // The range is 100.
            assert!((found[place] - expected).abs() < 1e-9, "{which:?} {place:?}");
        }
    }
}

#[test]
fn is_the_weighted_mean_of_what_there_is_at_the_border_and_around_holes() {
    let array = array();
    let numbers = array.mapv(f64::from);
    for which in WAYS {
        for padding in [None, Some(Padding { low: -50.0, high: -20.0 })] {
            let log = Log::default();
            let mut whole =
                volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
            whole.meta.padding = padding;
            let counts = |x: f64| padding.is_none() || x > -20.0;
            let found = read(blur(whole, SIGMA_MM).unwrap());
            assert_near(&found, &plain(&numbers, sigma(affine()), counts));
        }
    }
}

#[test]
fn nan_stays_nan_and_does_not_spread() {
    let mut array = array().mapv(f64::from);
    array.slice_mut(s![4..6, 3..9, 5]).fill(f64::NAN);
    for which in WAYS {
        let log = Log::default();
        let whole = volume::<f64>(dims_of(&array), AnyPlanes::F64(planes(&array, which, &log)));
        let found = read(blur(whole, SIGMA_MM).unwrap());
        assert_near(&found, &plain(&array, sigma(affine()), |x| !x.is_nan()));
    }
}

#[test]
fn a_constant_stays_itself_however_wide_the_blur() {
    let array = Array3::from_elem((3, 4, 5), 7_u8);
    for sigma in [1e-3, 0.7, 40.0, 1e300] {
        for which in WAYS {
            let log = Log::default();
            let whole = volume::<u8>(dims_of(&array), AnyPlanes::U8(planes(&array, which, &log)));
            let found = read(blur(whole, sigma).unwrap());
            assert!(found.iter().all(|x| (x - 7.0).abs() < 1e-13), "{sigma} {which:?}");
        }
    }
}

#[test]
fn threads_change_nothing() {
    let array = array();
    let log = Log::default();
    let whole =
        volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, Way::Positioned, &log)));
    let Volume { planes: AnyPlanes::F64(Planes::Positioned(inner)), .. } =
        blur(whole, SIGMA_MM).unwrap()
    else {
        panic!("not positioned")
    };
    let next = std::sync::atomic::AtomicUsize::new(0);
    let parts = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4)
            .map(|_| {
                scope.spawn(|| {
                    let mut made = Vec::new();
                    loop {
                        let k = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                        if k >= 10 {
                            return made;
                        }
                        let mut plane = Array2::zeros((14, 20));
                        inner.read_plane(k, plane.view_mut()).unwrap();
                        made.push((k, plane));
                    }
                })
            })
            .collect();
        workers.into_iter().flat_map(|w| w.join().unwrap()).collect::<Vec<_>>()
    });
    let log = Log::default();
    let alone = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, Way::Ordered, &log)));
    let alone = read(blur(alone, SIGMA_MM).unwrap());
    for (k, plane) in parts {
        assert_eq!(alone.index_axis(ndarray::Axis(0), k), plane, "plane {k}");
    }
}

#[test]
fn planes_asked_for_one_after_another_are_read_once() {
    let array = array();
    for which in [Way::Positioned, Way::Ordered] {
        let log = Log::default();
        let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
        read(blur(whole, SIGMA_MM).unwrap());
        let mut planes = log.planes.lock().unwrap().clone();
        planes.sort_unstable();
        assert_eq!(planes, (0..10).collect::<Vec<_>>());
    }
}

#[test]
fn crop_blur_and_downsample_stand_on_one_another() {
    let array = array();
    let part = array.slice(s![1..9, 2..13, 3..20]).mapv(f64::from);
    let blurred = plain(&part, sigma(affine()), |_| true);
    for which in WAYS {
        let log = Log::default();
        let whole = volume::<i16>(dims_of(&array), AnyPlanes::I16(planes(&array, which, &log)));
        let whole = crop(whole, &[3..20, 2..13, 1..9]).unwrap();
        let coarse = downsample(blur(whole, SIGMA_MM).unwrap(), [2, 1, 3]).unwrap();
        // Block (1, 2, 0) begins at sample (5, 4, 1) of the whole and is 2 x 1 x 3.
        assert_eq!(coarse.meta.grid.to_voxel.apply([1.0, 2.0, 0.0]), [5.5, 4.0, 2.0]);
        let found = read(coarse);
        let mean = blurred.slice(s![0..3, 2, 2..4]).mean().unwrap();
        assert!((found[[0, 2, 1]] - mean).abs() < 1e-10);
        assert_eq!(found.dim(), (3, 11, 9));
    }
}

#[test]
fn what_cannot_be_blurred_is_refused_before_it_is_read() {
    let array = Array3::<u8>::zeros((3, 2, 2));
    let log = Log::default();
    let whole = || volume::<u8>(dims_of(&array), AnyPlanes::U8(planes(&array, Way::Ordered, &log)));
    for sigma in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(blur(whole(), sigma).err().unwrap().to_string().starts_with("blur "));
    }
    let mut uneven = whole();
    let origins = [0.0, 1.0, 3.0].map(|z| [0.0, 0.0, z]).to_vec();
    uneven.meta.grid = Grid::uneven(dims_of(&array), Affine::IDENTITY, origins);
    let refused = blur(uneven, 1.0).err().unwrap();
    assert_eq!(refused.to_string(), "the planes are not evenly spaced, so they cannot be blurred");
    let mut large = whole();
    large.meta.grid = Grid::new(Dims::checked(20_000, 20_000, 900, 1).unwrap(), Affine::IDENTITY);
    let refused = blur(large, 2.0).err().unwrap();
    assert_eq!(refused.kind(), Kind::TooLarge);
    assert!(refused.to_string().contains("17 planes"), "{refused}");
    let same_bytes = blur(whole(), 0.0).unwrap();
    assert!(matches!(same_bytes.planes, AnyPlanes::U8(_)));
    assert!(same(&read(same_bytes), &array.mapv(f64::from)));
    assert!(log.planes.lock().unwrap().len() == 3);
}
