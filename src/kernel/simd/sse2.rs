//! SSE2, which every x86-64 processor has: the comparison; the rest is the plain code.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::bits::BitPlane;
use super::super::key::Threshold;
use super::super::region::Region;
use super::prefetch;

macro_rules! key {
    ($key:ident, $n:literal, |$v:ident, $flip:ident, $at:ident| $reaches:expr, $set:ident) => {
        pub(in super::super) mod $key {
            use super::*;

            #[target_feature(enable = "sse2")]
            pub(in super::super) fn fill(
                samples: &[$key],
                threshold: Threshold<$key>,
                region: Region,
                out: &mut BitPlane,
            ) {
                let ($flip, $at) = ($set(threshold.flip), $set(threshold.at));
                let $flip: __m128i = must_cast($flip);
                out.fill_with(samples, region, |chunk| {
                    prefetch(chunk);
                    let parts: [[__m128i; $n]; 64 / (16 / size_of::<$key>()) / $n] =
                        must_cast(*chunk);
                    let bits = 64 / parts.len();
                    let mut word = 0;
                    for (i, $v) in parts.into_iter().enumerate() {
                        word |= u64::from($reaches) << (i * bits);
                    }
                    word
                });
            }
        }
    };
}

key!(i8, 1, |v, flip, at| !(_mm_movemask_epi8(below_i8(v[0], flip, at)) as u16), _mm_set1_epi8);
key!(
    i16,
    2,
    |v, flip, at| {
        let below = v.map(|v| _mm_cmpgt_epi16(at, _mm_xor_si128(v, flip)));
        !(_mm_movemask_epi8(_mm_packs_epi16(below[0], below[1])) as u16)
    },
    _mm_set1_epi16
);
key!(
    i32,
    4,
    |v, flip, at| {
        let below = v.map(|v| _mm_cmpgt_epi32(at, _mm_xor_si128(v, flip)));
        let [low, high] =
            [[below[0], below[1]], [below[2], below[3]]].map(|[a, b]| _mm_packs_epi32(a, b));
        !(_mm_movemask_epi8(_mm_packs_epi16(low, high)) as u16)
    },
    _mm_set1_epi32
);
key!(
    f32,
    4,
    |v, flip, at| {
        let reached =
            v.map(|v| _mm_castps_si128(_mm_cmpge_ps(_mm_castsi128_ps(_mm_xor_si128(v, flip)), at)));
        let [low, high] = [[reached[0], reached[1]], [reached[2], reached[3]]]
            .map(|[a, b]| _mm_packs_epi32(a, b));
        _mm_movemask_epi8(_mm_packs_epi16(low, high)) as u16
    },
    _mm_set1_ps
);
key!(
    f64,
    1,
    |v, flip, at| {
        let v = _mm_castsi128_pd(_mm_xor_si128(v[0], flip));
        _mm_movemask_pd(_mm_cmpge_pd(v, at)) as u8
    },
    _mm_set1_pd
);

#[target_feature(enable = "sse2")]
#[inline]
fn below_i8(v: __m128i, flip: __m128i, at: __m128i) -> __m128i {
    _mm_cmpgt_epi8(at, _mm_xor_si128(v, flip))
}
