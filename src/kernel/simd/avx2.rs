//! AVX2: the comparison, emission by two half permutes, and the plain code compiled for BMI.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::bits::BitPlane;
use super::super::emit::Triangles;
use super::super::family::Family;
use super::super::gather::Gathered;
use super::super::key::Threshold;
use super::super::layer::{Cells, Counts, Layer, row_cells};
use super::super::normal::Surroundings;
use super::super::region::Region;
use super::super::tetra::{Between, Crossings, Kind, TetraTriangles};
use super::super::vertices::{Instructions, LayerEdges, LayerSlots, Placing, Plane, Slots};
use super::prefetch;
use crate::mesh::Position;
use crate::volume::Sample;

macro_rules! key {
    ($key:ident, $n:literal, |$v:ident, $flip:ident, $at:ident| $reaches:expr, $set:ident) => {
        pub(in super::super) mod $key {
            use super::*;

            #[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
            pub(in super::super) fn fill(
                samples: &[$key],
                threshold: Threshold<$key>,
                region: Region,
                out: &mut BitPlane,
            ) {
                let ($flip, $at) = ($set(threshold.flip), $set(threshold.at));
                let $flip: __m256i = must_cast($flip);
                out.fill_with(samples, region, |chunk| {
                    prefetch(chunk);
                    let parts: [[__m256i; $n]; 64 / (32 / size_of::<$key>()) / $n] =
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

key!(
    i8,
    1,
    |v, flip, at| {
        let below = _mm256_cmpgt_epi8(at, _mm256_xor_si256(v[0], flip));
        !(_mm256_movemask_epi8(below) as u32)
    },
    _mm256_set1_epi8
);
key!(
    i16,
    2,
    |v, flip, at| {
        let below = v.map(|v| _mm256_cmpgt_epi16(at, _mm256_xor_si256(v, flip)));
        // Packing works on each half by itself: quarters 0 2 1 3, put in order again.
        let packed = _mm256_packs_epi16(below[0], below[1]);
        !(_mm256_movemask_epi8(_mm256_permute4x64_epi64::<0b11_01_10_00>(packed)) as u32)
    },
    _mm256_set1_epi16
);
key!(
    i32,
    1,
    |v, flip, at| {
        let below = _mm256_cmpgt_epi32(at, _mm256_xor_si256(v[0], flip));
        !(_mm256_movemask_ps(_mm256_castsi256_ps(below)) as u8)
    },
    _mm256_set1_epi32
);
key!(
    f32,
    1,
    |v, flip, at| {
        let v = _mm256_castsi256_ps(_mm256_xor_si256(v[0], flip));
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GE_OQ>(v, at)) as u8
    },
    _mm256_set1_ps
);
key!(
    f64,
    2,
    |v, flip, at| {
        let reached = v.map(|v| {
            let v = _mm256_castsi256_pd(_mm256_xor_si256(v, flip));
            _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GE_OQ>(v, at)) as u8
        });
        reached[0] | reached[1] << 4
    },
    _mm256_set1_pd
);

/// The plain code, with the instructions for single bits that came with AVX2.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn fill_layer(
    counts: &Counts,
    planes: [&BitPlane; 2],
    dims: (usize, usize),
    cells: Cells,
    out: &mut Layer,
) {
    let words = planes[0].row_words();
    out.fill_with(planes, dims, cells, |rows, mask, out| row_cells(counts, rows, words, mask, out));
}

/// Emission: sixteen ids are two registers, so each half of the output is chosen from both.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn emit(triangles: &Triangles<'_>, out: &mut [u32]) {
    triangles.emit_with(
        out,
        |tables, running, cases, out| {
            let mut ids: [__m256i; 2] = must_cast(*running);
            let mut at = 0;
            for &case in cases {
                let case = usize::from(case);
                let n = 3 * usize::from(tables.n_triangles[case]);
                store(permute(ids, tables.ids[case]), n, at, out);
                at += n;
                ids = add(ids, tables.crossed[case]);
            }
            *running = must_cast(ids);
            at
        },
        |ids, locals, n, at, out| store(permute(must_cast(*ids), locals), n, at, out),
    );
}

/// The ids of sixteen local ids.
#[target_feature(enable = "avx2")]
#[inline]
fn permute(ids: [__m256i; 2], locals: [u8; 16]) -> [__m256i; 2] {
    let locals: __m128i = must_cast(locals);
    [locals, _mm_bsrli_si128::<8>(locals)].map(|locals| {
        let locals = _mm256_cvtepu8_epi32(locals);
        let [low, high] = ids.map(|ids| _mm256_permutevar8x32_epi32(ids, locals));
        let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(locals));
        _mm256_castps_si256(_mm256_blendv_ps(
            _mm256_castsi256_ps(low),
            _mm256_castsi256_ps(high),
            is_high,
        ))
    })
}

#[target_feature(enable = "avx2")]
#[inline]
fn add(ids: [__m256i; 2], by: [u8; 16]) -> [__m256i; 2] {
    let by: __m128i = must_cast(by);
    [
        _mm256_add_epi32(ids[0], _mm256_cvtepu8_epi32(by)),
        _mm256_add_epi32(ids[1], _mm256_cvtepu8_epi32(_mm_bsrli_si128::<8>(by))),
    ]
}

/// Stores all sixteen ids where there is room, since what follows is written later; else the first
/// `n`.
#[inline]
fn store(ids: [__m256i; 2], n: usize, at: usize, out: &mut [u32]) {
    let ids: [u32; 16] = must_cast(ids);
    let out = out.get_mut(at..).unwrap_or_default();
    if let Some(slots) = out.first_chunk_mut() {
        *slots = ids;
    } else {
        for (slot, id) in out.iter_mut().zip(ids).take(n) {
            *slot = id;
        }
    }
}

/// Vertices, the plain code compiled for wider registers.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn vertices<T: Sample>(edges: &LayerEdges<'_, T>, out: LayerSlots<'_>) {
    let gather = Gathered::add;
    match &edges.around {
        None => {
            let place = |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| f.place(g, out.positions);
            edges.make_with(out, &Instructions { gather, place });
        }
        Some(around) => {
            let place = |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| {
                with_normals(around, f, g, out);
            };
            edges.make_with(out, &Instructions { gather, place });
        }
    }
}

#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn ghosts<T: Sample>(placing: &Placing, plane: Plane<'_, T>, out: &mut [Position]) {
    let place = |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| f.place(g, out.positions);
    placing.ghosts_with(plane, out, &Instructions { gather: Gathered::add, place });
}

/// A function of its own, so that it is compiled once for all places that call it.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
fn with_normals<T: Sample>(
    around: &Surroundings<'_, T>,
    family: &Family<'_, T>,
    edges: &Gathered,
    out: Slots<'_>,
) {
    around.vertices(family, edges, out);
}

/// Tetrahedra: the plain code, with the instructions for single bits.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn count_diagonals(
    region: Region,
    kind: Kind,
    [low, high]: [&BitPlane; 2],
    out: &mut Crossings,
) {
    out.fill_with(region, kind, low, high);
}

#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn diagonal_vertices<T: Sample>(
    placing: &Placing,
    between: &Between<'_, T>,
    out: &mut [Position],
) {
    between.place(placing, out);
}

#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn emit_tetra(triangles: &TetraTriangles<'_>, out: &mut [u32]) {
    triangles.emit_portable(out);
}
