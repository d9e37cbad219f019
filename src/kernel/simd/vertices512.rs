//! AVX-512: a word's crossings gathered at once, vertices placed sixteen at once.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::family::Family;
use super::super::gather::{Gathered, LANES};
use super::super::vertices::{Instructions, LayerEdges, LayerSlots, Placing, Plane, Slots};
use super::normals512;
use super::samples512::{Samples, Values, halves};
use crate::mesh::Position;
use crate::volume::Sample;

/// Makes the vertices of a layer, with their normals where those are wanted.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn vertices<T: Sample>(edges: &LayerEdges<'_, T>, out: LayerSlots<'_>) {
    match &edges.around {
        None => positions(edges, out),
        Some(around) => normals512::vertices(edges, around, out),
    }
}

#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
fn positions<T: Sample>(edges: &LayerEdges<'_, T>, out: LayerSlots<'_>) {
    let place = |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| place(f, g, out.positions);
    edges.make_with(out, &Instructions { gather: gather_word(), place });
}

#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn ghosts<T: Sample>(placing: &Placing, plane: Plane<'_, T>, out: &mut [Position]) {
    let place = |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| place(f, g, out.positions);
    placing.ghosts_with(plane, out, &Instructions { gather: gather_word(), place });
}

/// [`gather`] as a value, which a function of an instruction set itself cannot be.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi2,popcnt")]
#[inline]
pub(super) fn gather_word() -> impl Fn(&mut Gathered, u64, u32, u32) {
    |gathered: &mut Gathered, word, first, r| gather(gathered, word, first, r)
}

/// The numbers of a word's set bits, all at once.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi2,popcnt")]
#[inline]
fn gather(gathered: &mut Gathered, word: u64, first: u32, r: u32) {
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
pub(super) fn place<T: Sample>(family: &Family<'_, T>, gathered: &Gathered, out: &mut [Position]) {
    let is_cap = family.cap != [false; 2];
    let [Some(low), Some(high)] = family.ends.map(|end| Samples::new(end)) else {
        if is_cap {
            return place_with(family, gathered, out, |_| [Values::zero(); 2]);
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
    ends: impl Fn(__m512i) -> [Values<T>; 2],
) {
    let lanes = FamilyLanes::new(family);
    // Whole batches are stored as such; a store of any length would be a call each.
    let (slots, last) = out.as_chunks_mut::<LANES>();
    let (mut slots, mut rest) = (slots.iter_mut(), [[0.0; 3]; LANES]);
    for (c, r) in gathered.batches() {
        let (c, r): (__m512i, __m512i) = (must_cast(*c), must_cast(*r));
        let [a, b] = ends(lanes.lower_ends(c, r));
        let t = lanes.crossings(a, b);
        *slots.next().unwrap_or(&mut rest) = lanes.positions(t, c, r);
    }
    last.copy_from_slice(&rest[..last.len()]);
}

/// The numbers of a `Family`, one in all lanes each.
pub(super) struct FamilyLanes {
    level: __m512d,
    epsilon: __m512d,
    most: __m512d,
    origin: [__m512d; 3],
    step: [__m512d; 3],
    step_i: [__m512d; 3],
    step_j: [__m512d; 3],
    back_ij: [__m512d; 2],
    nx: __m512i,
    back: __m512i,
    border_c: [__m512i; 2],
    border_r: [__m512i; 2],
    /// All lanes where the edges come out of the border, or go into it.
    cap: [u16; 2],
}

impl FamilyLanes {
    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn new<T>(family: &Family<'_, T>) -> Self {
        let set = |x: f64| _mm512_set1_pd(x);
        let set_int = |x: u32| _mm512_set1_epi32(x as i32);
        Self {
            level: set(family.level),
            epsilon: set(family.epsilon),
            most: set(1.0 - family.epsilon),
            origin: family.origin.map(set),
            step: family.step.map(set),
            step_i: family.step_i.map(set),
            step_j: family.step_j.map(set),
            back_ij: family.back_ij.map(set),
            nx: set_int(family.nx as u32),
            back: set_int(family.back as u32),
            border_c: family.border_c.map(set_int),
            border_r: family.border_r.map(set_int),
            cap: family.cap.map(|all| if all { 0xFFFF } else { 0 }),
        }
    }

    /// Where the samples at the lower ends of edges stand in their plane.
    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn lower_ends(&self, c: __m512i, r: __m512i) -> __m512i {
        _mm512_sub_epi32(_mm512_add_epi32(_mm512_mullo_epi32(r, self.nx), c), self.back)
    }

    /// The places of vertices between samples, in two halves: the definition is `crossing`.
    #[target_feature(enable = "avx512f,avx512dq")]
    #[inline]
    pub(super) fn crossings<T: Sample>(&self, a: Values<T>, b: Values<T>) -> [__m512d; 2] {
        let (a, b) = (a.to_f64(), b.to_f64());
        [0, 1].map(|half: usize| {
            let (a, b) = (a[half], b[half]);
            let rise = _mm512_sub_pd(b, a);
            let t = _mm512_div_pd(_mm512_sub_pd(self.level, a), rise);
            let t = _mm512_min_pd(_mm512_max_pd(t, self.epsilon), self.most);
            let infinity = _mm512_set1_pd(f64::INFINITY);
            let finite = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_abs_pd(rise), infinity);
            _mm512_mask_blend_pd(finite, _mm512_set1_pd(0.5), t)
        })
    }

    /// The vertices at `t` of edges between samples, and on edges out of the border or into it.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn positions(&self, t: [__m512d; 2], c: __m512i, r: __m512i) -> [Position; LANES] {
        let [from, into] = [0, 1].map(|side: usize| {
            let in_c = _mm512_cmpeq_epi32_mask(c, self.border_c[side]);
            self.cap[side] | in_c | _mm512_cmpeq_epi32_mask(r, self.border_r[side])
        });
        let (c, r) = (halves(c), halves(r));
        must_cast([0, 1].map(|half: usize| {
            let of_half = |mask: u16| (mask >> (8 * half)) as u8;
            let t = _mm512_mask_blend_pd(of_half(into), t[half], self.epsilon);
            let t = _mm512_mask_blend_pd(of_half(from), t, self.most);
            let i = _mm512_sub_pd(_mm512_cvtepu32_pd(c[half]), self.back_ij[0]);
            let j = _mm512_sub_pd(_mm512_cvtepu32_pd(r[half]), self.back_ij[1]);
            let along = |axis: usize| {
                let along_j = _mm512_mul_pd(j, self.step_j[axis]);
                let row = _mm512_add_pd(self.origin[axis], along_j);
                let sample = _mm512_add_pd(row, _mm512_mul_pd(i, self.step_i[axis]));
                _mm512_cvtpd_ps(_mm512_add_pd(sample, _mm512_mul_pd(t, self.step[axis])))
            };
            interleaved(along(0), along(1), along(2))
        }))
    }
}

/// x, y and z of eight positions, as they stand in memory.
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
#[inline]
pub(super) fn interleaved(x: __m256, y: __m256, z: __m256) -> [Position; 8] {
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
