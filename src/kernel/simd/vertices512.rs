//! AVX-512: a word's crossings gathered at once, vertices placed eight at once.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::family::Family;
use super::super::gather::{Gathered, LANES};
use super::super::layer::ActiveWord;
use super::super::vertices::{LayerVertices, Means, Placing, Plane};
use super::samples512::Samples;
use crate::geom::vec3::Vec3;
use crate::mesh::Position;
use crate::volume::Sample;

#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn vertices<T: Sample>(
    placing: &Placing,
    words: &[ActiveWord],
    planes: [Plane<'_, T>; 2],
    step: Vec3,
    out: LayerVertices<'_>,
) {
    let near = planes.map(|plane| plane.samples);
    let means = Means {
        gather: |g: &mut Gathered, word, first, r| gather(g, word, first, r),
        place: |f: &Family<'_, T>, g: &Gathered, out: &mut [Position]| place(f, g, out),
    };
    placing.layer_with(words, planes, near, step, out, &means);
}

#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn ghosts<T: Sample>(placing: &Placing, plane: Plane<'_, T>, out: &mut [Position]) {
    let means = Means {
        gather: |g: &mut Gathered, word, first, r| gather(g, word, first, r),
        place: |f: &Family<'_, T>, g: &Gathered, out: &mut [Position]| place(f, g, out),
    };
    placing.ghosts_with(plane, out, &means);
}

/// The numbers of a word's set bits, all at once.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi2,popcnt")]
#[inline]
pub(super) fn gather(gathered: &mut Gathered, word: u64, first: u32, r: u32) {
    const NUMBERS: [u8; 64] = {
        let mut numbers = [0; 64];
        let mut n = 0;
        while n < 64 {
            numbers[n] = n as u8;
            n += 1;
        }
        numbers
    };
    let places: [__m128i; 4] =
        must_cast(_mm512_maskz_compress_epi8(word, must_cast::<[u8; 64], __m512i>(NUMBERS)));
    let first = _mm512_set1_epi32(first as i32);
    let r: [u32; 16] = must_cast(_mm512_set1_epi32(r as i32));
    let n = word.count_ones() as usize;
    gathered.extend(n, |n| {
        let c = _mm512_add_epi32(_mm512_cvtepu8_epi32(places[n % 4]), first);
        (must_cast(c), r)
    });
}

/// The definition is `Family::vertex`: the same operations in the same order.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx2,bmi1,bmi2,popcnt,lzcnt")]
fn place<T: Sample>(family: &Family<'_, T>, gathered: &Gathered, out: &mut [Position]) {
    let is_cap = family.cap != [false; 2];
    let [Some(low), Some(high)] = family.ends.map(|end| Samples::new(end)) else {
        if is_cap {
            return place_with(family, gathered, out, |_| [_mm512_setzero_pd(); 2]);
        }
        return family.place(gathered, out);
    };
    if family.back == 1 {
        place_with(family, gathered, out, |places| low.pairs_at(places));
    } else {
        place_with(family, gathered, out, |places| [low.at(places), high.at(places)]);
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx2,bmi1,bmi2,popcnt,lzcnt")]
#[inline]
fn place_with<T: Sample>(
    family: &Family<'_, T>,
    gathered: &Gathered,
    out: &mut [Position],
    ends: impl Fn(__m256i) -> [__m512d; 2],
) {
    let set = |x: f64| _mm512_set1_pd(x);
    let (level, epsilon) = (set(family.level), set(family.epsilon));
    let most = set(1.0 - family.epsilon);
    let (origin, step) = (family.origin.map(set), family.step.map(set));
    let (step_i, step_j) = (family.step_i.map(set), family.step_j.map(set));
    let (back_i, back_j) = (set(family.back_ij[0]), set(family.back_ij[1]));
    let (nx, back) = (_mm256_set1_epi32(family.nx as i32), _mm256_set1_epi32(family.back as i32));
    let same = |a: __m256i, b: u32| _mm256_cmpeq_epi32_mask(a, _mm256_set1_epi32(b as i32));
    let all = family.cap.map(|all| if all { 0xFF } else { 0 });
    // Whole batches are stored as such; a store of any length would be a call each.
    let (slots, last) = out.as_chunks_mut::<LANES>();
    let (mut slots, mut rest) = (slots.iter_mut(), [[0.0; 3]; LANES]);
    for (c, r) in gathered.batches() {
        let (c, r): (__m256i, __m256i) = (must_cast(*c), must_cast(*r));
        let places = _mm256_sub_epi32(_mm256_add_epi32(_mm256_mullo_epi32(r, nx), c), back);
        let [a, b] = ends(places);

        let rise = _mm512_sub_pd(b, a);
        let t = _mm512_div_pd(_mm512_sub_pd(level, a), rise);
        let t = _mm512_min_pd(_mm512_max_pd(t, epsilon), most);
        let infinity = set(f64::INFINITY);
        let finite = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_abs_pd(rise), infinity);
        let t = _mm512_mask_blend_pd(finite, set(0.5), t);
        let into = all[1] | same(c, family.border_c[1]) | same(r, family.border_r[1]);
        let from = all[0] | same(c, family.border_c[0]) | same(r, family.border_r[0]);
        let t = _mm512_mask_blend_pd(into, t, epsilon);
        let t = _mm512_mask_blend_pd(from, t, most);

        let i = _mm512_sub_pd(_mm512_cvtepu32_pd(c), back_i);
        let j = _mm512_sub_pd(_mm512_cvtepu32_pd(r), back_j);
        let along = |axis: usize| {
            let row = _mm512_add_pd(origin[axis], _mm512_mul_pd(j, step_j[axis]));
            let sample = _mm512_add_pd(row, _mm512_mul_pd(i, step_i[axis]));
            _mm512_cvtpd_ps(_mm512_add_pd(sample, _mm512_mul_pd(t, step[axis])))
        };
        let vertices = interleaved(along(0), along(1), along(2));
        *slots.next().unwrap_or(&mut rest) = vertices;
    }
    last.copy_from_slice(&rest[..last.len()]);
}

/// x, y and z of eight positions, as they stand in memory.
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
#[inline]
pub(super) fn interleaved(x: __m256, y: __m256, z: __m256) -> [Position; LANES] {
    // Lane n of xy is x of n, lane 8 + n is y of n; lanes from 16 on are those of z.
    const FIRST: [u32; 16] = [0, 8, 16, 1, 9, 17, 2, 10, 18, 3, 11, 19, 4, 12, 20, 5];
    const LAST: [u32; 16] = [13, 21, 6, 14, 22, 7, 15, 23, 0, 0, 0, 0, 0, 0, 0, 0];
    let xy = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(x), y);
    let z = _mm512_castps256_ps512(z);
    let first: [f32; 16] = must_cast(_mm512_permutex2var_ps(xy, must_cast(FIRST), z));
    let last: [f32; 16] = must_cast(_mm512_permutex2var_ps(xy, must_cast(LAST), z));
    let mut all = [0.0; 24];
    all[..16].copy_from_slice(&first);
    all[16..].copy_from_slice(&last[..8]);
    must_cast(all)
}
