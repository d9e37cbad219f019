//! AVX-512: comparison into masks, 64 cases at a time, emission by one permute.

#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

use bytemuck::must_cast;

use super::super::bits::BitPlane;
use super::super::emit::Triangles;
use super::super::key::Threshold;
use super::super::layer::{
    ActiveWord, CASE_SLACK, Cells, Counts, FourRows, Layer, RowCells, RowMask, RowOut, UNSETTLED,
    UnsettledCell,
};
use super::super::region::Region;
use super::super::tetra::TetraTriangles;
use super::prefetch;

macro_rules! key {
    ($key:ident, |$v:ident, $flip:ident, $at:ident| $reaches:expr, $set:ident) => {
        pub(in super::super) mod $key {
            use super::*;

            #[target_feature(
                enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,avx512vpopcntdq,gfni,avx2,bmi1,bmi2,popcnt,lzcnt"
            )]
            pub(in super::super) fn fill(
                samples: &[$key],
                threshold: Threshold<$key>,
                region: Region,
                out: &mut BitPlane,
            ) {
                let ($flip, $at) = ($set(threshold.flip), $set(threshold.at));
                let $flip: __m512i = must_cast($flip);
                out.fill_with(samples, region, |chunk| {
                    prefetch(chunk);
                    let parts: [__m512i; size_of::<$key>()] = must_cast(*chunk);
                    let bits = 64 / parts.len();
                    let mut word = 0;
                    for (i, $v) in parts.into_iter().enumerate() {
                        let $v = _mm512_xor_si512($v, $flip);
                        word |= u64::from($reaches) << (i * bits);
                    }
                    word
                });
            }
        }
    };
}

key!(i8, |v, flip, at| _mm512_cmpge_epi8_mask(v, at), _mm512_set1_epi8);
key!(i16, |v, flip, at| _mm512_cmpge_epi16_mask(v, at), _mm512_set1_epi16);
key!(i32, |v, flip, at| _mm512_cmpge_epi32_mask(v, at), _mm512_set1_epi32);
key!(
    f32,
    |v, flip, at| _mm512_cmp_ps_mask::<_CMP_GE_OQ>(_mm512_castsi512_ps(v), at),
    _mm512_set1_ps
);
key!(
    f64,
    |v, flip, at| _mm512_cmp_pd_mask::<_CMP_GE_OQ>(_mm512_castsi512_pd(v), at),
    _mm512_set1_pd
);

/// The definition is `layer::row_cells`; this finds the active words eight at a time and the cases
/// of a word at once.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,avx512vpopcntdq,gfni,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn fill_layer(
    counts: &Counts,
    planes: [&BitPlane; 2],
    dims: (usize, usize),
    cells: Cells,
    out: &mut Layer,
) {
    let words = planes[0].row_words();
    let tables = CaseTables::new(counts);
    out.fill_with(planes, dims, cells, |rows, mask, out| tables.row_cells(rows, words, mask, out));
}

/// What turns words into cases and cases into counts, in registers.
struct CaseTables {
    gather: __m512i,
    columns: __m512i,
    counts: [__m512i; 4],
}

impl CaseTables {
    #[target_feature(enable = "avx512f")]
    fn new(counts: &Counts) -> Self {
        // Eight words make an 8 × 64 matrix of bits. Byte j of each of them, gathered into one
        // quadword, is an 8 × 8 matrix, which the affine instruction transposes when it is given
        // the unit columns; it takes the rows from the last byte to the first.
        let mut gather = [0u8; 64];
        let mut columns = [0u8; 64];
        for j in 0..8 {
            for k in 0..8 {
                gather[8 * j + (7 - k)] = (8 * k + j) as u8;
                columns[8 * j + k] = 1 << k;
            }
        }
        Self { gather: must_cast(gather), columns: must_cast(columns), counts: must_cast(*counts) }
    }

    #[target_feature(
        enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,avx512vpopcntdq,gfni,avx2,bmi1,bmi2,popcnt,lzcnt"
    )]
    #[inline]
    fn row_cells(
        &self,
        rows: FourRows<'_>,
        words: usize,
        mask: RowMask,
        row: RowOut<'_>,
    ) -> RowCells {
        let mut n_cells = 0;
        let mut sums = _mm512_setzero_si512();
        let mut first = 0;
        while first < words {
            // The word after a whole row of words holds the border alone, and is mostly zero.
            if first + 1 == words && rows.iter().all(|row| row[first] >> 63 | row[first + 1] == 0) {
                break;
            }
            let right = rows.map(|row| load(row, first + 1));
            let left = rows.map(|row| load(row, first));
            let left = [0, 1, 2, 3].map(|i| _mm512_shldi_epi64::<1>(right[i], left[i]));
            let any =
                or3(or3(left[0], left[1], left[2]), left[3], or3(right[0], right[1], right[2]));
            let all =
                and3(and3(left[0], left[1], left[2]), left[3], and3(right[0], right[1], right[2]));
            let any = _mm512_or_si512(any, right[3]);
            let all = _mm512_and_si512(all, right[3]);
            let active = _mm512_andnot_si512(all, any);
            let mut some = _mm512_test_epi64_mask(active, active);
            let active: [u64; 8] = must_cast(active);
            while some != 0 {
                let i = some.trailing_zeros() as usize;
                some &= some - 1;
                let w = first + i;
                row.words.push(ActiveWord { q: row.q, w: w as u32 });
                let active = active[i % 8] & mask.word(w);
                let all_cases = self.cases(rows, w);
                let found = _mm512_maskz_compress_epi8(active, all_cases);
                let n = active.count_ones() as usize;
                if let Some(out) = row.cases.get_mut(n_cells..).and_then(<[u8]>::first_chunk_mut) {
                    let slots: &mut [u8; CASE_SLACK] = out;
                    *slots = must_cast(found);
                }
                let count = self.count(found);
                let is_unsettled = _mm512_movepi8_mask(count);
                let is_unsettled = is_unsettled & mask_of_first(n);
                let plain = _mm512_maskz_mov_epi8(!is_unsettled & mask_of_first(n), count);
                sums = _mm512_add_epi64(sums, _mm512_sad_epu8(plain, _mm512_setzero_si512()));
                if is_unsettled != 0 {
                    remember_unsettled(
                        (w, n_cells),
                        active,
                        is_unsettled,
                        must_cast(found),
                        row.unsettled,
                    );
                }
                n_cells += n;
            }
            first += 8;
        }
        RowCells { n_cells, n_triangles: _mm512_reduce_add_epi64(sums) as u32 }
    }

    /// The cases of the 64 cells of word `w`, active or not.
    #[target_feature(enable = "avx512f,avx512vbmi,gfni")]
    #[inline]
    fn cases(&self, rows: FourRows<'_>, w: usize) -> __m512i {
        let right = rows.map(|row| row[w + 1]);
        let left = rows.map(|row| row[w + 1] << 1 | row[w] >> 63);
        let [a, b, c, d] = left;
        let [e, f, g, h] = right;
        let words: __m512i = must_cast([a, e, b, f, c, g, d, h]);
        let bytes = _mm512_permutexvar_epi8(self.gather, words);
        _mm512_gf2p8affine_epi64_epi8::<0>(self.columns, bytes)
    }

    /// The count of each of 64 cases.
    #[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
    #[inline]
    fn count(&self, cases: __m512i) -> __m512i {
        let [a, b, c, d] = self.counts;
        let low = _mm512_permutex2var_epi8(a, cases, b);
        let high = _mm512_permutex2var_epi8(c, cases, d);
        _mm512_mask_blend_epi8(_mm512_movepi8_mask(cases), low, high)
    }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn load(row: &[u64], at: usize) -> __m512i {
    match row.get(at..).and_then(<[u64]>::first_chunk::<8>) {
        Some(words) => must_cast(*words),
        None => _mm512_setzero_si512(),
    }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn or3(a: __m512i, b: __m512i, c: __m512i) -> __m512i {
    _mm512_ternarylogic_epi64::<0xFE>(a, b, c)
}

#[target_feature(enable = "avx512f")]
#[inline]
fn and3(a: __m512i, b: __m512i, c: __m512i) -> __m512i {
    _mm512_ternarylogic_epi64::<0x80>(a, b, c)
}

/// The lowest `n` bits, `n` up to 64.
#[inline]
fn mask_of_first(n: usize) -> u64 {
    if n >= 64 { !0 } else { (1 << n) - 1 }
}

/// Notes the cells whose count is marked [`UNSETTLED`]: `is_unsettled` has a bit for each active cell.
/// Before word `w` the row has `n_cells` active ones.
#[target_feature(enable = "bmi1,bmi2")]
#[inline(never)]
fn remember_unsettled(
    (w, n_cells): (usize, usize),
    active: u64,
    is_unsettled: u64,
    cases: [u8; 64],
    unsettled: &mut Vec<UnsettledCell>,
) {
    let mut places = _pdep_u64(is_unsettled, active);
    let mut is_unsettled = is_unsettled;
    while is_unsettled != 0 {
        let nth = is_unsettled.trailing_zeros() as usize;
        let c = (w * 64) as u32 + places.trailing_zeros();
        unsettled.push(UnsettledCell { c, nth: (n_cells + nth) as u32, case: cases[nth % 64] });
        is_unsettled &= is_unsettled - 1;
        places &= places - 1;
    }
}

const _: () = assert!(UNSETTLED == 0x80, "the sign bit of a byte, as `movepi8_mask` sees it");

/// Emission: sixteen ids are one register, and so are the local ids of up to five triangles.
#[target_feature(
    enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,avx512vpopcntdq,gfni,avx2,bmi1,bmi2,popcnt,lzcnt"
)]
pub(super) fn emit(triangles: &Triangles<'_>, out: &mut [u32]) {
    triangles.emit_with(
        out,
        |tables, running, cases, out| {
            let mut ids: __m512i = must_cast(*running);
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
#[target_feature(enable = "avx512f")]
#[inline]
fn permute(ids: __m512i, locals: [u8; 16]) -> __m512i {
    _mm512_permutexvar_epi32(_mm512_cvtepu8_epi32(must_cast(locals)), ids)
}

#[target_feature(enable = "avx512f")]
#[inline]
fn add(ids: __m512i, by: [u8; 16]) -> __m512i {
    _mm512_add_epi32(ids, _mm512_cvtepu8_epi32(must_cast(by)))
}

/// Stores all sixteen ids where there is room, since what follows is written later; else the first
/// `n`.
#[target_feature(enable = "avx512f")]
#[inline]
fn store(ids: __m512i, n: usize, at: usize, out: &mut [u32]) {
    let out = out.get_mut(at..).unwrap_or_default();
    if let Some(slots) = out.first_chunk_mut::<16>() {
        *slots = must_cast(ids);
    } else {
        let ids: [u32; 16] = must_cast(ids);
        for (slot, id) in out.iter_mut().zip(ids).take(n) {
            *slot = id;
        }
    }
}

/// Tetrahedra: thirty-two ids are two registers, from which one permute chooses sixteen.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx2,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn emit_tetra(triangles: &TetraTriangles<'_>, out: &mut [u32]) {
    triangles.emit_with(out, |tables, running, cases, out| {
        let mut ids: [__m512i; 2] = must_cast(running);
        let mut at = 0;
        for &case in cases {
            let case = usize::from(case);
            let n = 3 * usize::from(tables.n_triangles[case]);
            for (&block, first) in tables.ids[case].iter().zip([0, 16, 32]) {
                if first < n {
                    let locals = _mm512_cvtepu8_epi32(must_cast(block));
                    let chosen = _mm512_permutex2var_epi32(ids[0], locals, ids[1]);
                    store(chosen, (n - first).min(16), at + first, out);
                }
            }
            at += n;
            let by: [[u8; 16]; 2] = must_cast(tables.crossed[case]);
            ids = [0, 1]
                .map(|half| _mm512_add_epi32(ids[half], _mm512_cvtepu8_epi32(must_cast(by[half]))));
        }
        at
    });
}
