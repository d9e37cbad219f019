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
    AGAINST, Around, LEAST_SQUARE, MOST_SQUARE, Making, Star, Surroundings, Within,
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
        let t = lanes.crossings(star.a, star.b);
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

/// The samples at the ends of edges and around them.
#[target_feature(enable = "avx512f,avx2")]
#[inline]
fn gather<T: Sample, const AXIS: usize>(
    [before, plane, after, beyond]: [Samples<'_, T>; 4],
    at: __m512i,
    nx: __m512i,
) -> Star<Values<T>> {
    let one = _mm512_set1_epi32(1);
    let (left, up, down) =
        (_mm512_sub_epi32(at, one), _mm512_sub_epi32(at, nx), _mm512_add_epi32(at, nx));
    match AXIS {
        0 => {
            let [outer_a, a, b, outer_b] = plane.fours_at(left);
            let ([a1, b1], [a2, b2]) = (plane.pairs_at(up), plane.pairs_at(down));
            let ([a3, b3], [a4, b4]) = (before.pairs_at(at), after.pairs_at(at));
            let (first, second) = ([[a1, a2], [b1, b2]], [[a3, a4], [b3, b4]]);
            Star { a, b, outer: [outer_a, outer_b], first, second }
        }
        1 => {
            let [a1, a, a2, _] = plane.fours_at(left);
            let [b1, b, b2, _] = plane.fours_at(_mm512_sub_epi32(down, one));
            let outer = [plane.at(up), plane.at(_mm512_add_epi32(down, nx))];
            let [a3, b3] = [before.at(at), before.at(down)];
            let [a4, b4] = [after.at(at), after.at(down)];
            Star { a, b, outer, first: [[a1, a2], [b1, b2]], second: [[a3, a4], [b3, b4]] }
        }
        _ => {
            let [a1, a, a2, _] = plane.fours_at(left);
            let [b1, b, b2, _] = after.fours_at(left);
            let outer = [before.at(at), beyond.at(at)];
            let second = [[plane.at(up), plane.at(down)], [after.at(up), after.at(down)]];
            Star { a, b, outer, first: [[a1, a2], [b1, b2]], second }
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
        star: &Star<Values<T>>,
        t: __m512,
    ) -> ([__m512; 3], u16) {
        let Star { a, b, outer: [before, after], first, second } = *star;
        let set = |x: f32| _mm512_set1_ps(x);
        let mul = |a, b| _mm512_mul_ps(a, b);
        let add = |a, b| _mm512_add_ps(a, b);
        let rest = _mm512_sub_ps(set(1.0), t);
        let mix = |low, high| add(mul(rest, low), mul(t, high));
        let central = |[low, high]: [Values<T>; 2]| mul(set(0.5), high.minus(low));
        let [low, high] = self.weights;
        let rise = b.minus(a);
        let slope_first = mix(central(first[0]), central(first[1]));
        let (along, slope_second);
        if AXIS == 2 {
            slope_second = mix(central(second[0]), central(second[1]));
            let l = add(mul(low[0], a.minus(before)), mul(low[1], rise));
            let h = add(mul(high[0], rise), mul(high[1], after.minus(b)));
            let straight = mix(l, h);
            along = match self.lean {
                None => straight,
                Some([low, high]) => {
                    let slopes = |end: usize| [central(first[end]), central(second[end])];
                    let ([p, q], [r, s]) = (slopes(0), slopes(1));
                    let l = add(mul(low[0], p), mul(low[1], q));
                    let h = add(mul(high[0], r), mul(high[1], s));
                    _mm512_sub_ps(straight, mix(l, h))
                }
            };
        } else {
            let [[a_low, a_high], [b_low, b_high]] = second;
            let l = add(mul(low[0], a.minus(a_low)), mul(low[1], a_high.minus(a)));
            let h = add(mul(high[0], b.minus(b_low)), mul(high[1], b_high.minus(b)));
            slope_second = mix(l, h);
            along = mix(central([before, b]), central([a, after]));
        }
        self.turned::<AXIS>(rise, along, slope_first, slope_second)
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
