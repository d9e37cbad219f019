//! AVX-512: samples at eight places at once, as `f64`.
//!
//! By the processor's gathers, which take half the time of eight loads one by one. A sample narrower
//! than four bytes is read in a window of four (or, with its neighbours, eight) bytes. Every place
//! is first brought into the plane, so a window never leaves it: what comes for a place outside is
//! no matter.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use crate::volume::{Sample, StoredType};

/// A plane whose samples can be read from eight places at once.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a, T>(&'a [T]);

/// The most samples that a window spans.
const WINDOW: usize = 4;

impl<'a, T: Sample> Samples<'a, T> {
    /// Nothing where the plane is smaller than a window, or larger than places can name.
    #[inline(always)]
    pub(super) fn new(samples: &'a [T]) -> Option<Self> {
        (WINDOW..=i32::MAX as usize).contains(&samples.len()).then_some(Self(samples))
    }

    /// The samples at eight places.
    #[target_feature(enable = "avx512f,avx512vl,avx2")]
    #[inline]
    pub(super) fn at(self, places: __m256i) -> __m512d {
        match T::TYPE {
            StoredType::F64 => self.doubles(places),
            StoredType::F32 => _mm512_cvtps_pd(_mm256_castsi256_ps(self.window(places, 1).0)),
            StoredType::I32 => _mm512_cvtepi32_pd(self.window(places, 1).0),
            StoredType::U32 => _mm512_cvtepu32_pd(self.window(places, 1).0),
            _ => {
                let (window, skipped) = self.window(places, 4 / size_of::<T>());
                Self::narrow(window, skipped)
            }
        }
    }

    /// The samples at eight places, and the ones after each of them.
    #[target_feature(enable = "avx512f,avx512vl,avx2")]
    #[inline]
    pub(super) fn pairs_at(self, places: __m256i) -> [__m512d; 2] {
        if size_of::<T>() < 4 {
            let (window, skipped) = self.window(places, 4 / size_of::<T>());
            let next = _mm256_add_epi32(skipped, _mm256_set1_epi32(1));
            [Self::narrow(window, skipped), Self::narrow(window, next)]
        } else {
            let next = _mm256_add_epi32(places, _mm256_set1_epi32(1));
            [self.at(places), self.at(next)]
        }
    }

    /// The samples at eight places, and the three after each of them, which must be there.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2")]
    #[inline]
    pub(super) fn fours_at(self, places: __m256i) -> [__m512d; 4] {
        if size_of::<T>() == 2 {
            let first = self.inside(places, WINDOW);
            let base = self.0.as_ptr().cast::<i64>();
            // SAFETY: `inside` leaves no place that four samples of two bytes would not follow.
            let four = unsafe { _mm512_i32gather_epi64::<2>(first, base) };
            let tops = [
                _mm512_slli_epi64::<48>(four),
                _mm512_slli_epi64::<32>(four),
                _mm512_slli_epi64::<16>(four),
                four,
            ];
            let is_signed = matches!(T::TYPE, StoredType::I16);
            tops.map(|top| {
                _mm512_cvtepi64_pd(if is_signed {
                    _mm512_srai_epi64::<48>(top)
                } else {
                    _mm512_srli_epi64::<48>(top)
                })
            })
        } else {
            let after = |n: i32| self.at(_mm256_add_epi32(places, _mm256_set1_epi32(n)));
            [self.at(places), after(1), after(2), after(3)]
        }
    }

    /// Samples narrower than 32 bits, `skipped` of them into each window.
    #[target_feature(enable = "avx512f,avx512vl,avx2")]
    #[inline]
    fn narrow(window: __m256i, skipped: __m256i) -> __m512d {
        // To the top of the window, from where a shift back down brings the sign with it.
        let up = if size_of::<T>() == 1 {
            _mm256_slli_epi32::<3>(_mm256_sub_epi32(_mm256_set1_epi32(3), skipped))
        } else {
            _mm256_slli_epi32::<4>(_mm256_sub_epi32(_mm256_set1_epi32(1), skipped))
        };
        let top = _mm256_sllv_epi32(window, up);
        let lanes = match T::TYPE {
            StoredType::I8 => _mm256_srai_epi32::<24>(top),
            StoredType::U8 => _mm256_srli_epi32::<24>(top),
            StoredType::I16 => _mm256_srai_epi32::<16>(top),
            _ => _mm256_srli_epi32::<16>(top),
        };
        _mm512_cvtepi32_pd(lanes)
    }

    /// Windows of four bytes, `n` samples each, that hold the samples at the places, and how many
    /// of a window's samples come before.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn window(self, places: __m256i, n: usize) -> (__m256i, __m256i) {
        let first = self.inside(places, n);
        let base = self.0.as_ptr().cast::<i32>();
        // SAFETY: `inside` leaves no place whose window of `n` samples would not lie in the plane.
        let window = unsafe {
            match size_of::<T>() {
                1 => _mm256_i32gather_epi32::<1>(base, first),
                2 => _mm256_i32gather_epi32::<2>(base, first),
                _ => _mm256_i32gather_epi32::<4>(base, first),
            }
        };
        (window, _mm256_sub_epi32(places, first))
    }

    #[target_feature(enable = "avx512f,avx2")]
    #[inline]
    fn doubles(self, places: __m256i) -> __m512d {
        let first = self.inside(places, 1);
        let base = self.0.as_ptr().cast::<f64>();
        // SAFETY: `inside` leaves no place outside the plane; its samples are `f64`.
        unsafe { _mm512_i32gather_pd::<8>(first, base) }
    }

    /// The places, those too near the end or beyond it moved back, so that `n` samples follow.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn inside(self, places: __m256i, n: usize) -> __m256i {
        let last = self.0.len() - n.min(WINDOW);
        _mm256_min_epu32(places, _mm256_set1_epi32(last as i32))
    }
}
