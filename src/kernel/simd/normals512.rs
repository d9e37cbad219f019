//! AVX-512: vertices and their normals, those of sixteen edges at once.
//!
//! The definitions are `Family::vertex` and `normal::Batch`: the same operations in the same order.
//! Edges at the border, and gradients that have no length, are left to the plain code.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::family::Family;
use super::super::gather::{Gathered, LANES};
use super::super::normal::{
    AGAINST, Around, LEAST_SQUARE, MOST_SQUARE, Making, Surroundings, Within,
};
use super::super::vertices::{Instructions, LayerEdges, LayerSlots, Slots};
use super::samples512::{Samples, Values, joined};
use super::vertices512::{FamilyLanes, gather_word, interleaved, place};
use crate::mesh::Normal;
use crate::volume::Sample;

/// Makes the vertices of a layer and their normals.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn vertices<T: Sample>(
    edges: &LayerEdges<'_, T>,
    around: &Surroundings<'_, T>,
    out: LayerSlots<'_>,
) {
    let place = |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| of_family(around, f, g, out);
    edges.make_with(out, &Instructions { gather: gather_word(), place });
}

/// The vertices on gathered edges of one family, and their normals.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
fn of_family<T: Sample>(
    around: &Surroundings<'_, T>,
    family: &Family<'_, T>,
    edges: &Gathered,
    out: Slots<'_>,
) {
    match (family.axis(), &around.plane, &around.between) {
        (0, Some(plane), _) => along::<T, 0>(plane, family, edges, out),
        (1, Some(plane), _) => along::<T, 1>(plane, family, edges, out),
        (2, _, Some(between)) => along::<T, 2>(between, family, edges, out),
        _ => {
            place(family, edges, out.positions);
            out.normals.unwrap_or_default().fill(around.z_cap);
        }
    }
}

#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi,avx512vbmi2,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
fn along<T: Sample, const AXIS: usize>(
    around: &Around<'_, T>,
    family: &Family<'_, T>,
    edges: &Gathered,
    out: Slots<'_>,
) {
    let (positions, normals) = (out.positions, out.normals.unwrap_or_default());
    let planes = around.planes.map(|samples| Samples::new(samples));
    let [Some(before), Some(plane), Some(after), Some(beyond)] = planes else {
        place(family, edges, positions);
        return around.normals::<AXIS>(edges, normals);
    };
    let planes = [before, plane, after, beyond];
    let lanes = FamilyLanes::new(family);
    let nx = _mm512_set1_epi32(family.nx as i32);
    let making = Factors::new(&around.making);
    let [columns, rows] = around.within::<AXIS>();
    let mut wanted = normals.len();
    let (slots, last) = positions.as_chunks_mut::<LANES>();
    let (normal_slots, last_normals) = normals.as_chunks_mut::<LANES>();
    let mut slots = slots.iter_mut().zip(normal_slots);
    let mut rest = ([[0.0; 3]; LANES], [[0.0; 3]; LANES]);
    for (c, r) in edges.batches() {
        let (slot, normal_slot) = slots.next().unwrap_or((&mut rest.0, &mut rest.1));
        let (c_lanes, r_lanes): (__m512i, __m512i) = (must_cast(*c), must_cast(*r));
        let star = gather::<T, AXIS>(planes, lanes.lower_ends(c_lanes, r_lanes), nx);
        let t = lanes.crossings(star[0], star[1]);
        *slot = lanes.positions(t, c_lanes, r_lanes);
        let ([x, y, z], usual) = making.normals::<T, AXIS>(&star, joined(t));
        *normal_slot = both_interleaved(x, y, z);
        let has_all = within(c_lanes, columns) & within(r_lanes, rows);
        let real = if wanted < LANES { (1 << wanted) - 1 } else { 0xFFFF };
        let mut odd = real & !(has_all & usual);
        while odd != 0 {
            let lane = odd.trailing_zeros() as usize % LANES;
            odd &= odd - 1;
            slot[lane] = family.vertex(c[lane], r[lane]);
            normal_slot[lane] = around.one::<AXIS>(c[lane], r[lane]);
        }
        wanted = wanted.saturating_sub(LANES);
    }
    last.copy_from_slice(&rest.0[..last.len()]);
    last_normals.copy_from_slice(&rest.1[..last_normals.len()]);
}

/// The lanes whose number lies in a range.
#[target_feature(enable = "avx512f")]
#[inline]
fn within(x: __m512i, range: Within) -> u16 {
    let from_first = _mm512_sub_epi32(x, _mm512_set1_epi32(range.first as i32));
    _mm512_cmplt_epu32_mask(from_first, _mm512_set1_epi32(range.n as i32))
}

/// x, y and z of sixteen normals, as they stand in memory.
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
#[inline]
fn both_interleaved(x: __m512, y: __m512, z: __m512) -> [Normal; LANES] {
    let lower = [x, y, z].map(|x| _mm512_castps512_ps256(x));
    let upper = [x, y, z].map(|x| _mm512_extractf32x8_ps::<1>(x));
    must_cast([lower, upper].map(|[x, y, z]| interleaved(x, y, z)))
}

/// The samples at the ends of edges and around them, ordered as in `normal::Star`.
#[target_feature(enable = "avx512f,avx2")]
#[inline]
fn gather<T: Sample, const AXIS: usize>(
    [before, plane, after, beyond]: [Samples<'_, T>; 4],
    at: __m512i,
    nx: __m512i,
) -> [Values<T>; 12] {
    let one = _mm512_set1_epi32(1);
    let (left, up, down) =
        (_mm512_sub_epi32(at, one), _mm512_sub_epi32(at, nx), _mm512_add_epi32(at, nx));
    match AXIS {
        0 => {
            let [c, a, b, d] = plane.fours_at(left);
            let ([e, g], [f, h]) = (plane.pairs_at(up), plane.pairs_at(down));
            let ([p, r], [q, s]) = (before.pairs_at(at), after.pairs_at(at));
            [a, b, c, d, e, f, g, h, p, q, r, s]
        }
        1 => {
            let [e, a, f, _] = plane.fours_at(left);
            let [g, b, h, _] = plane.fours_at(_mm512_sub_epi32(down, one));
            let (c, d) = (plane.at(up), plane.at(_mm512_add_epi32(down, nx)));
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
    weights: [[__m512; 2]; 2],
    lean: Option<[[__m512; 2]; 2]>,
    columns: [[__m512; 3]; 3],
    squares: [__m512; 3],
}

impl Factors {
    #[target_feature(enable = "avx512f")]
    #[inline]
    fn new(making: &Making) -> Self {
        let set = |x: f32| _mm512_set1_ps(x);
        let lean = making.across.map(|across| across.lean.map(|x| x as f32));
        Self {
            weights: making.across.map(|across| across.weights.map(|x| set(x as f32))),
            lean: (lean != [[0.0; 2]; 2]).then(|| lean.map(|of| of.map(set))),
            columns: making.columns.map(|of| of.map(set)),
            squares: making.squares.map(set),
        }
    }

    /// Normals along x, y and z at `t`, and the lanes in which their lengths could be made 1.
    #[target_feature(enable = "avx512f,avx512dq")]
    #[inline]
    fn normals<T: Sample, const AXIS: usize>(
        &self,
        star: &[Values<T>; 12],
        t: __m512,
    ) -> ([__m512; 3], u16) {
        let [a, b, before, after, p, q, r, s, v, w, x, y] = *star;
        let set = |x: f32| _mm512_set1_ps(x);
        let mul = |a, b| _mm512_mul_ps(a, b);
        let add = |a, b| _mm512_add_ps(a, b);
        let rest = _mm512_sub_ps(set(1.0), t);
        let mix = |low, high| add(mul(rest, low), mul(t, high));
        let central = |low: Values<T>, high: Values<T>| mul(set(0.5), high.minus(low));
        let [low, high] = self.weights;
        let rise = b.minus(a);
        let first = mix(central(p, q), central(r, s));
        let (along, second);
        if AXIS == 2 {
            second = mix(central(v, w), central(x, y));
            let l = add(mul(low[0], a.minus(before)), mul(low[1], rise));
            let h = add(mul(high[0], rise), mul(high[1], after.minus(b)));
            let straight = mix(l, h);
            along = match self.lean {
                None => straight,
                Some([low, high]) => {
                    let l = add(mul(low[0], central(p, q)), mul(low[1], central(v, w)));
                    let h = add(mul(high[0], central(r, s)), mul(high[1], central(x, y)));
                    _mm512_sub_ps(straight, mix(l, h))
                }
            };
        } else {
            let l = add(mul(low[0], a.minus(v)), mul(low[1], w.minus(a)));
            let h = add(mul(high[0], b.minus(x)), mul(high[1], y.minus(b)));
            second = mix(l, h);
            along = mix(central(before, b), central(a, after));
        }
        self.turned::<AXIS>(rise, along, first, second)
    }

    /// Slopes turned into directions of length 1.
    #[target_feature(enable = "avx512f,avx512dq")]
    #[inline]
    fn turned<const AXIS: usize>(
        &self,
        rise: __m512,
        along: __m512,
        first: __m512,
        second: __m512,
    ) -> ([__m512; 3], u16) {
        let set = |x: f32| _mm512_set1_ps(x);
        let mul = |a, b| _mm512_mul_ps(a, b);
        let add = |a, b| _mm512_add_ps(a, b);
        let squares = self.squares;
        let [own, u, v] = [[0, 1, 2], [1, 0, 2], [2, 0, 1]][AXIS].map(|axis: usize| squares[axis]);
        // The sign of the rise on a one, as `copysign` gives it.
        let sign = _mm512_and_ps(rise, set(-0.0));
        let facing = mul(along, _mm512_or_ps(set(1.0), sign));
        let leans_back = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(facing, _mm512_setzero_ps());
        let length = mul(mul(mul(set(AGAINST), own), along), along);
        let across = add(mul(mul(u, first), first), mul(mul(v, second), second));
        let far = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(length, across);
        let along = _mm512_mask_blend_ps(leans_back & far, along, rise);
        let [di, dj, dk] = match AXIS {
            0 => [along, first, second],
            1 => [first, along, second],
            _ => [first, second, along],
        };
        let [i, j, k] = self.columns;
        let to = |n: usize| add(add(mul(i[n], di), mul(j[n], dj)), mul(k[n], dk));
        let [x, y, z] = [to(0), to(1), to(2)];
        let square = add(add(mul(x, x), mul(y, y)), mul(z, z));
        let usual = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(square, set(LEAST_SQUARE))
            & _mm512_cmp_ps_mask::<_CMP_LT_OQ>(square, set(MOST_SQUARE));
        let length = _mm512_sqrt_ps(square);
        let unit = |x| _mm512_add_ps(_mm512_div_ps(x, length), _mm512_setzero_ps());
        ([unit(x), unit(y), unit(z)], usual)
    }
}
