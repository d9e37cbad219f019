//! AVX-512: samples at sixteen places at once.
//!
//! By the processor's gathers, which take half the time of loads one by one. A sample narrower than
//! four bytes is read in a window of four (or, with its neighbours, eight) bytes. Every place is first
//! brought into the plane, so a window never leaves it: what comes for a place outside is no matter.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;
use std::marker::PhantomData;

use bytemuck::must_cast;

use crate::volume::{Sample, StoredType};

/// A plane whose samples can be read from sixteen places at once.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a, T>(&'a [T]);

/// The most samples that a window spans.
const WINDOW: usize = 4;

impl<'a, T: Sample> Samples<'a, T> {
    /// Nothing where the plane is smaller than a window, or larger than places can name.
    #[inline(always)]
    pub(super) fn new(samples: &'a [T]) -> Option<Self> {
        // A gather's width goes by `TYPE`, the plane's length by the size.
        const { assert!(size_of::<T>() == T::TYPE.size()) };
        (WINDOW..=i32::MAX as usize).contains(&samples.len()).then_some(Self(samples))
    }

    /// The samples at the places.
    #[target_feature(enable = "avx512f,avx2")]
    #[inline]
    pub(super) fn at(self, places: __m512i) -> Values<T> {
        match T::TYPE {
            StoredType::F64 => Values::halves(halves(places).map(|half| self.doubles(half))),
            StoredType::F32 | StoredType::I32 | StoredType::U32 => {
                Values::of_words(self.window(places, 1).0)
            }
            _ => {
                let (window, skipped) = self.window(places, 4 / size_of::<T>());
                Self::narrow(window, skipped)
            }
        }
    }

    /// The samples at the places, and the ones after each of them, which must be there.
    #[target_feature(enable = "avx512f,avx2")]
    #[inline]
    pub(super) fn pairs_at(self, places: __m512i) -> [Values<T>; 2] {
        match size_of::<T>() {
            1 => {
                let (window, skipped) = self.window(places, 4);
                let next = _mm512_add_epi32(skipped, _mm512_set1_epi32(1));
                [Self::narrow(window, skipped), Self::narrow(window, next)]
            }
            2 => {
                let (window, _) = self.window(places, 2);
                [Values::of_tops(_mm512_slli_epi32::<16>(window)), Values::of_tops(window)]
            }
            _ => [self.at(places), self.at(after(places, 1))],
        }
    }

    /// The samples at the places, and the three after each of them, which must be there.
    #[target_feature(enable = "avx512f,avx2")]
    #[inline]
    pub(super) fn fours_at(self, places: __m512i) -> [Values<T>; 4] {
        match size_of::<T>() {
            1 => {
                let (window, _) = self.window(places, 4);
                [
                    Values::of_tops(_mm512_slli_epi32::<24>(window)),
                    Values::of_tops(_mm512_slli_epi32::<16>(window)),
                    Values::of_tops(_mm512_slli_epi32::<8>(window)),
                    Values::of_tops(window),
                ]
            }
            2 => {
                let [low, high] = self.doubled_windows(places);
                [
                    Values::of_tops(_mm512_slli_epi32::<16>(low)),
                    Values::of_tops(low),
                    Values::of_tops(_mm512_slli_epi32::<16>(high)),
                    Values::of_tops(high),
                ]
            }
            _ => [
                self.at(places),
                self.at(after(places, 1)),
                self.at(after(places, 2)),
                self.at(after(places, 3)),
            ],
        }
    }

    /// Samples narrower than 32 bits, `skipped` of them into each window.
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn narrow(window: __m512i, skipped: __m512i) -> Values<T> {
        let last = _mm512_set1_epi32(4 / size_of::<T>() as i32 - 1);
        let behind = _mm512_sub_epi32(last, skipped);
        let bits = if size_of::<T>() == 1 {
            _mm512_slli_epi32::<3>(behind)
        } else {
            _mm512_slli_epi32::<4>(behind)
        };
        Values::of_tops(_mm512_sllv_epi32(window, bits))
    }

    /// Windows of four bytes, `n` samples each, that hold the samples at the places, and how many
    /// of a window's samples come before.
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn window(self, places: __m512i, n: usize) -> (__m512i, __m512i) {
        let first = self.inside(places, n);
        let base = self.0.as_ptr().cast::<i32>();
        // SAFETY: `inside` leaves no place whose window of `n` samples would not lie in the plane.
        let window = unsafe {
            match size_of::<T>() {
                1 => _mm512_i32gather_epi32::<1>(first, base),
                2 => _mm512_i32gather_epi32::<2>(first, base),
                _ => _mm512_i32gather_epi32::<4>(first, base),
            }
        };
        (window, _mm512_sub_epi32(places, first))
    }

    /// The first and the second four of the eight bytes from each place.
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn doubled_windows(self, places: __m512i) -> [__m512i; 2] {
        const EVEN: [u32; 16] = [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30];
        const ODD: [u32; 16] = [1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31];
        let [a, b] = halves(self.inside(places, WINDOW)).map(|first| {
            let base = self.0.as_ptr().cast::<i64>();
            // SAFETY: `inside` leaves no place that four samples of two bytes would not follow.
            unsafe { _mm512_i32gather_epi64::<2>(first, base) }
        });
        [EVEN, ODD].map(|which| _mm512_permutex2var_epi32(a, must_cast(which), b))
    }

    #[target_feature(enable = "avx512f")]
    #[inline]
    fn doubles(self, places: __m256i) -> __m512d {
        let last = (self.0.len() - 1) as i32;
        let first = _mm256_min_epu32(places, _mm256_set1_epi32(last));
        let base = self.0.as_ptr().cast::<f64>();
        // SAFETY: no place is outside the plane; its samples are `f64`, as `new` asserts of `TYPE`.
        unsafe { _mm512_i32gather_pd::<8>(first, base) }
    }

    /// The places, those too near the end or beyond it moved back, so that `n` samples follow.
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn inside(self, places: __m512i, n: usize) -> __m512i {
        let last = self.0.len() - n.min(WINDOW);
        _mm512_min_epu32(places, _mm512_set1_epi32(last as i32))
    }
}

/// Samples in sixteen lanes: integers of 16 bits or less as `i32`, `f32` as they are, others as
/// `f64`, in two halves.
#[derive(Clone, Copy)]
pub(super) struct Values<T>([__m512d; 2], PhantomData<T>);

impl<T: Sample> Values<T> {
    /// All zero.
    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn zero() -> Self {
        Self([_mm512_setzero_pd(); 2], PhantomData)
    }

    /// The lower eight and the upper eight, as `f64`.
    #[target_feature(enable = "avx512f,avx512dq")]
    #[inline]
    pub(super) fn to_f64(self) -> [__m512d; 2] {
        match T::TYPE {
            StoredType::F64 | StoredType::I32 | StoredType::U32 => self.0,
            StoredType::F32 => {
                let values = _mm512_castpd_ps(self.0[0]);
                [_mm512_castps512_ps256(values), _mm512_extractf32x8_ps::<1>(values)]
                    .map(|half| _mm512_cvtps_pd(half))
            }
            _ => halves(_mm512_castpd_si512(self.0[0])).map(|half| _mm512_cvtepi32_pd(half)),
        }
    }

    /// The definition is `Sample::minus`.
    #[target_feature(enable = "avx512f,avx512dq")]
    #[inline]
    pub(super) fn minus(self, other: Self) -> __m512 {
        let (Self([a, b], _), Self([c, d], _)) = (self, other);
        match T::TYPE {
            StoredType::F64 | StoredType::I32 | StoredType::U32 => {
                joined([_mm512_sub_pd(a, c), _mm512_sub_pd(b, d)])
            }
            StoredType::F32 => _mm512_sub_ps(_mm512_castpd_ps(a), _mm512_castpd_ps(c)),
            _ => {
                let rise = _mm512_sub_epi32(_mm512_castpd_si512(a), _mm512_castpd_si512(c));
                _mm512_cvtepi32_ps(rise)
            }
        }
    }

    #[inline(always)]
    fn halves(values: [__m512d; 2]) -> Self {
        Self(values, PhantomData)
    }

    /// Of samples of 32 bits.
    #[target_feature(enable = "avx512f,avx2")]
    #[inline]
    fn of_words(words: __m512i) -> Self {
        match T::TYPE {
            StoredType::I32 => Self::halves(halves(words).map(|half| _mm512_cvtepi32_pd(half))),
            StoredType::U32 => Self::halves(halves(words).map(|half| _mm512_cvtepu32_pd(half))),
            _ => Self::halves([_mm512_castsi512_pd(words); 2]),
        }
    }

    /// Of narrower samples in the topmost bits of the lanes.
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn of_tops(tops: __m512i) -> Self {
        let lanes = match T::TYPE {
            StoredType::I8 => _mm512_srai_epi32::<24>(tops),
            StoredType::U8 => _mm512_srli_epi32::<24>(tops),
            StoredType::I16 => _mm512_srai_epi32::<16>(tops),
            _ => _mm512_srli_epi32::<16>(tops),
        };
        Self::halves([_mm512_castsi512_pd(lanes); 2])
    }
}

/// Lanes rounded to `f32`.
#[target_feature(enable = "avx512f,avx512dq")]
#[inline]
pub(super) fn joined([low, high]: [__m512d; 2]) -> __m512 {
    let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(low));
    _mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(high))
}

/// The lower eight lanes and the upper eight.
#[target_feature(enable = "avx512f")]
#[inline]
pub(super) fn halves(lanes: __m512i) -> [__m256i; 2] {
    [_mm512_castsi512_si256(lanes), _mm512_extracti64x4_epi64::<1>(lanes)]
}

/// The places `n` further on.
#[target_feature(enable = "avx512f")]
#[inline]
fn after(places: __m512i, n: i32) -> __m512i {
    _mm512_add_epi32(places, _mm512_set1_epi32(n))
}
