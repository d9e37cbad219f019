//! AVX-512: the normals of eight edges at once.
//!
//! The definition is `normal::Lanes`: the same operations in the same order. Edges at the border,
//! and gradients that have no length, are left to the plain code.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::family::Family;
use super::super::gather::{Gathered, LANES};
use super::super::layer::ActiveWord;
use super::super::normal::{AGAINST, Around, Making, Surroundings, Within};
use super::super::vertices::{LayerVertices, Means, Placing, Plane};
use super::samples512::Samples;
use super::vertices512::{gather as gather_word, interleaved};
use crate::geom::vec3::Vec3;
use crate::mesh::Normal;
use crate::volume::Sample;

/// Makes the normals of a layer's vertices.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn normals<T: Sample>(
    placing: &Placing,
    words: &[ActiveWord],
    planes: [Plane<'_, T>; 2],
    step: Vec3,
    around: &Surroundings<'_, T>,
    out: LayerVertices<'_>,
) {
    let means = Means {
        gather: |g: &mut Gathered, word, first, r| gather_word(g, word, first, r),
        place: |f: &Family<'_, T>, g: &Gathered, out: &mut [Normal]| of_family(around, f, g, out),
    };
    placing.layer_with(words, planes, around.outer_planes(), step, out, &means);
}

/// The normals of the vertices on gathered edges of one family.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
fn of_family<T: Sample>(
    around: &Surroundings<'_, T>,
    family: &Family<'_, T>,
    edges: &Gathered,
    out: &mut [Normal],
) {
    match (family.axis(), &around.plane, &around.between) {
        (0, Some(plane), _) => along::<T, 0>(plane, edges, out),
        (1, Some(plane), _) => along::<T, 1>(plane, edges, out),
        (2, _, Some(between)) => along::<T, 2>(between, edges, out),
        _ => around.normals(family, edges, out),
    }
}

#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
fn along<T: Sample, const AXIS: usize>(
    around: &Around<'_, T>,
    edges: &Gathered,
    out: &mut [Normal],
) {
    let planes = around.planes.map(|samples| Samples::new(samples));
    let [Some(before), Some(plane), Some(after), Some(beyond)] = planes else {
        return around.normals::<AXIS>(edges, out);
    };
    let planes = [before, plane, after, beyond];
    let nx = _mm256_set1_epi32(around.dims.0 as i32);
    let back = _mm256_set1_epi32([1, around.dims.0 as i32, 0][AXIS]);
    let making = Factors::new(&around.making);
    let [columns, rows] = around.within::<AXIS>();
    let mut wanted = out.len();
    let (slots, last) = out.as_chunks_mut::<LANES>();
    let (mut slots, mut rest) = (slots.iter_mut(), [[0.0; 3]; LANES]);
    for (c, r) in edges.batches() {
        let slot = slots.next().unwrap_or(&mut rest);
        let (c_lanes, r_lanes): (__m256i, __m256i) = (must_cast(*c), must_cast(*r));
        let places = _mm256_add_epi32(_mm256_mullo_epi32(r_lanes, nx), c_lanes);
        let star = gather::<T, AXIS>(planes, _mm256_sub_epi32(places, back), nx);
        let ([x, y, z], usual) = making.normals::<AXIS>(&star);
        *slot = interleaved(x, y, z);
        let has_all = within(c_lanes, columns) & within(r_lanes, rows);
        let real = if wanted < LANES { (1 << wanted) - 1 } else { 0xFF };
        let mut odd = real & !(has_all & usual);
        while odd != 0 {
            let lane = odd.trailing_zeros() as usize % LANES;
            odd &= odd - 1;
            slot[lane] = around.one::<AXIS>(c[lane], r[lane]);
        }
        wanted = wanted.saturating_sub(LANES);
    }
    last.copy_from_slice(&rest[..last.len()]);
}

/// The lanes whose number lies in a range.
#[target_feature(enable = "avx512f,avx512vl")]
#[inline]
fn within(x: __m256i, range: Within) -> u8 {
    let from_first = _mm256_sub_epi32(x, _mm256_set1_epi32(range.first as i32));
    _mm256_cmplt_epu32_mask(from_first, _mm256_set1_epi32(range.n as i32))
}

/// The samples at the ends of edges and around them, ordered as in `normal::Star`.
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2")]
#[inline]
fn gather<T: Sample, const AXIS: usize>(
    [before, plane, after, beyond]: [Samples<'_, T>; 4],
    at: __m256i,
    nx: __m256i,
) -> [__m512d; 12] {
    let one = _mm256_set1_epi32(1);
    let (left, up, down) =
        (_mm256_sub_epi32(at, one), _mm256_sub_epi32(at, nx), _mm256_add_epi32(at, nx));
    match AXIS {
        0 => {
            let [c, a, b, d] = plane.fours_at(left);
            let ([e, g], [f, h]) = (plane.pairs_at(up), plane.pairs_at(down));
            let ([p, r], [q, s]) = (before.pairs_at(at), after.pairs_at(at));
            [a, b, c, d, e, f, g, h, p, q, r, s]
        }
        1 => {
            let [e, a, f, _] = plane.fours_at(left);
            let [g, b, h, _] = plane.fours_at(_mm256_sub_epi32(down, one));
            let (c, d) = (plane.at(up), plane.at(_mm256_add_epi32(down, nx)));
            let (p, r) = (before.at(at), before.at(down));
            let (q, s) = (after.at(at), after.at(down));
            [a, b, c, d, e, f, g, h, p, q, r, s]
        }
        _ => {
            let [e, a, f, _] = plane.fours_at(left);
            let [g, b, h, _] = after.fours_at(left);
            let (c, d) = (before.at(at), beyond.at(at));
            let (p, q) = (plane.at(up), plane.at(down));
            let (r, s) = (after.at(up), after.at(down));
            [a, b, c, d, e, f, g, h, p, q, r, s]
        }
    }
}

/// The numbers of a `Making`, one in all lanes each.
struct Factors {
    level: __m512d,
    epsilon: __m512d,
    weights: [[__m512d; 2]; 2],
    lean: Option<[[__m512d; 2]; 2]>,
    columns: [[__m512d; 3]; 3],
    squares: [__m512d; 3],
}

impl Factors {
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn new(making: &Making) -> Self {
        let set = |x: f64| _mm512_set1_pd(x);
        let lean = making.across.map(|across| across.lean);
        Self {
            level: set(making.level),
            epsilon: set(making.epsilon),
            weights: making.across.map(|across| across.weights.map(set)),
            lean: (lean != [[0.0; 2]; 2]).then(|| lean.map(|of| of.map(set))),
            columns: making.columns.map(|of| of.map(set)),
            squares: making.squares.map(set),
        }
    }

    /// Normals along x, y and z, and the lanes in which their lengths could be made 1.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2")]
    #[inline]
    fn normals<const AXIS: usize>(&self, star: &[__m512d; 12]) -> ([__m256; 3], u8) {
        let [a, b, before, after, p, q, r, s, v, w, x, y] = *star;
        let set = |x: f64| _mm512_set1_pd(x);
        let sub = |a, b| _mm512_sub_pd(a, b);
        let mul = |a, b| _mm512_mul_pd(a, b);
        let add = |a, b| _mm512_add_pd(a, b);
        let rise = sub(b, a);
        let t = _mm512_div_pd(sub(self.level, a), rise);
        let t = _mm512_max_pd(t, self.epsilon);
        let t = _mm512_min_pd(t, sub(set(1.0), self.epsilon));
        let finite = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_abs_pd(rise), set(f64::INFINITY));
        let t = _mm512_mask_blend_pd(finite, set(0.5), t);
        let rest = sub(set(1.0), t);
        let mix = |low, high| add(mul(rest, low), mul(t, high));
        let central = |low, high| mul(set(0.5), sub(high, low));
        let [low, high] = self.weights;
        let first = mix(central(p, q), central(r, s));
        let (along, second);
        if AXIS == 2 {
            second = mix(central(v, w), central(x, y));
            let l = add(mul(low[0], sub(a, before)), mul(low[1], rise));
            let h = add(mul(high[0], rise), mul(high[1], sub(after, b)));
            let straight = mix(l, h);
            along = match self.lean {
                None => straight,
                Some([low, high]) => {
                    let l = add(mul(low[0], central(p, q)), mul(low[1], central(v, w)));
                    let h = add(mul(high[0], central(r, s)), mul(high[1], central(x, y)));
                    sub(straight, mix(l, h))
                }
            };
        } else {
            let l = add(mul(low[0], sub(a, v)), mul(low[1], sub(w, a)));
            let h = add(mul(high[0], sub(b, x)), mul(high[1], sub(y, b)));
            second = mix(l, h);
            along = mix(central(before, b), central(a, after));
        }
        self.turned::<AXIS>(rise, along, first, second)
    }

    /// Slopes turned into directions of length 1.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2")]
    #[inline]
    fn turned<const AXIS: usize>(
        &self,
        rise: __m512d,
        along: __m512d,
        first: __m512d,
        second: __m512d,
    ) -> ([__m256; 3], u8) {
        let set = |x: f64| _mm512_set1_pd(x);
        let mul = |a, b| _mm512_mul_pd(a, b);
        let add = |a, b| _mm512_add_pd(a, b);
        let squares = self.squares;
        let [own, u, v] = [[0, 1, 2], [1, 0, 2], [2, 0, 1]][AXIS].map(|axis: usize| squares[axis]);
        // The sign of the rise on a one, as `copysign` gives it.
        let sign = _mm512_and_pd(rise, set(-0.0));
        let facing = mul(along, _mm512_or_pd(set(1.0), sign));
        let leans_back = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(facing, _mm512_setzero_pd());
        let length = mul(mul(mul(set(AGAINST), own), along), along);
        let across = add(mul(mul(u, first), first), mul(mul(v, second), second));
        let far = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(length, across);
        let along = _mm512_mask_blend_pd(leans_back & far, along, rise);
        let [di, dj, dk] = match AXIS {
            0 => [along, first, second],
            1 => [first, along, second],
            _ => [first, second, along],
        };
        let [i, j, k] = self.columns;
        let to = |n: usize| add(add(mul(i[n], di), mul(j[n], dj)), mul(k[n], dk));
        let [x, y, z] = [to(0), to(1), to(2)];
        let square = add(add(mul(x, x), mul(y, y)), mul(z, z));
        let by = _mm512_div_pd(set(1.0), _mm512_sqrt_pd(square));
        let usual = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(square, set(1e-200))
            & _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, set(1e200));
        let rounded = |x| _mm256_add_ps(_mm512_cvtpd_ps(mul(x, by)), _mm256_setzero_ps());
        ([rounded(x), rounded(y), rounded(z)], usual)
    }
}
