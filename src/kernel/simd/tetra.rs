//! Marching tetrahedra: the plain code with the instructions for single bits, and emission by
//! permutes of two registers.

#[cfg(target_arch = "x86_64")]
#[allow(clippy::wildcard_imports, reason = "a list of intrinsics says less than the code")]
use std::arch::x86_64::*;

#[cfg(target_arch = "x86_64")]
use bytemuck::must_cast;

use super::super::bits::BitPlane;
use super::super::cpu::Cpu;
use super::super::tetra::{Between, Crossings, Kind, Region, TetraTriangles};
use super::super::vertices::Placing;
#[cfg(target_arch = "x86_64")]
use super::avx512::store;
use crate::mesh::Position;
use crate::volume::Sample;

/// Counts the crossed diagonals of a kind.
pub(in super::super) fn count(
    cpu: Cpu,
    region: &Region,
    kind: Kind,
    [low, high]: [&BitPlane; 2],
    out: &mut Crossings,
) {
    dispatch!(
        cpu,
        out.fill_with(region, kind, low, high),
        out.fill_with(region, kind, low, high),
        count_avx2(region, kind, [low, high], out),
        count_avx2(region, kind, [low, high], out)
    );
}

/// Makes the vertices on diagonals of one kind.
pub(in super::super) fn vertices<T: Sample>(
    cpu: Cpu,
    placing: &Placing,
    between: &Between<'_, T>,
    out: &mut [Position],
) {
    dispatch!(
        cpu,
        between.place(placing, out),
        between.place(placing, out),
        vertices_avx2(placing, between, out),
        vertices_avx2(placing, between, out)
    );
}

/// Writes the triangles of a layer.
pub(in super::super) fn emit(cpu: Cpu, triangles: &TetraTriangles<'_>, out: &mut [u32]) {
    dispatch!(
        cpu,
        triangles.emit_portable(out),
        triangles.emit_portable(out),
        emit_avx2(triangles, out),
        emit_avx512(triangles, out)
    );
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
fn count_avx2(region: &Region, kind: Kind, [low, high]: [&BitPlane; 2], out: &mut Crossings) {
    out.fill_with(region, kind, low, high);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
fn vertices_avx2<T: Sample>(placing: &Placing, between: &Between<'_, T>, out: &mut [Position]) {
    between.place(placing, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt,lzcnt")]
fn emit_avx2(triangles: &TetraTriangles<'_>, out: &mut [u32]) {
    triangles.emit_portable(out);
}

/// Thirty-two ids are two registers, from which one permute chooses sixteen.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx2,bmi1,bmi2,popcnt,lzcnt")]
fn emit_avx512(triangles: &TetraTriangles<'_>, out: &mut [u32]) {
    triangles.emit_with(out, |tables, lanes, cases, out| {
        let mut ids: [__m512i; 2] = must_cast(lanes);
        let mut at = 0;
        for &case in cases {
            let case = usize::from(case);
            let n = 3 * usize::from(tables.n_triangles[case]);
            for (&block, first) in tables.corners[case].iter().zip([0, 16, 32]) {
                if first < n {
                    let lanes = _mm512_cvtepu8_epi32(must_cast(block));
                    let chosen = _mm512_permutex2var_epi32(ids[0], lanes, ids[1]);
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
