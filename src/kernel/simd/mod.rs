//! The loops of the kernel, compiled once an instruction set, and the choice among them.
//!
//! Each set has a file whose functions are safe and enabled for that set. What is `unsafe` is only
//! the call of such a function from here, where [`Detected`] says that the processor has the set,
//! hints, and the gathers of `samples512`. Each set gives the same bits as the plain code, which is
//! the definition.
#![allow(unsafe_code)]
#![allow(
    clippy::redundant_closure_for_method_calls,
    reason = "a method is not general enough in lifetimes"
)]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod normals512;
#[cfg(target_arch = "x86_64")]
mod samples512;
#[cfg(target_arch = "x86_64")]
mod sse2;
#[cfg(target_arch = "x86_64")]
mod vertices512;

use super::bits::BitPlane;
use super::cpu::{Cpu, Detected};
use super::emit::Triangles;
use super::family::Family;
use super::gather::Gathered;
use super::key::Threshold;
use super::layer::{Cells, Counts, Layer, row_cells};
use super::region::Region;
use super::vertices::{Instructions, LayerEdges, LayerSlots, Placing, Plane, Slots};
use crate::mesh::Position;
use crate::volume::Sample;

/// Runs the widest function that `cpu` allows.
macro_rules! dispatch {
    ($cpu:expr, $scalar:expr, $sse2:expr, $avx2:expr, $avx512:expr) => {
        match $cpu.cpu() {
            Cpu::Scalar => $scalar,
            #[cfg(target_arch = "x86_64")]
            Cpu::Sse2 => $sse2,
            // SAFETY: a `Detected` is made of a set only where the processor has it.
            #[cfg(target_arch = "x86_64")]
            Cpu::Avx2 => unsafe { $avx2 },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Cpu::Avx512 => unsafe { $avx512 },
            #[cfg(not(target_arch = "x86_64"))]
            _ => $scalar,
        }
    };
}

pub(super) mod tetra;

macro_rules! keys {
    ($($key:ident),*) => {$(
        pub(super) mod $key {
            use super::*;

            /// Fills a bit plane from a plane of samples.
            pub(in super::super) fn fill(
                cpu: Detected,
                samples: &[$key],
                threshold: Threshold<$key>,
                region: Region,
                out: &mut BitPlane,
            ) {
                dispatch!(
                    cpu,
                    out.fill_with(samples, region, |chunk| threshold.word(chunk)),
                    // SAFETY: every x86-64 processor has SSE2.
                    unsafe { sse2::$key::fill(samples, threshold, region, out) },
                    avx2::$key::fill(samples, threshold, region, out),
                    avx512::$key::fill(samples, threshold, region, out)
                );
            }
        }
    )*};
}

keys!(i8, i16, i32, f32, f64);

/// Asks for the samples that come after these, one page on or less: the processor itself looks ahead
/// too little for comparing at the speed of memory.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn prefetch<T>(chunk: &[T; 64]) {
    const AHEAD_BYTES: usize = 1024;
    ask_lines(chunk.as_ptr().wrapping_byte_add(AHEAD_BYTES), size_of::<T>());
}

/// Asks for the 64 samples from a place on, which may go beyond the plane.
#[inline(always)]
pub(super) fn ask<T>(plane: &[T], from: usize) {
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (plane, from);
    #[cfg(target_arch = "x86_64")]
    ask_lines(plane.as_ptr().wrapping_add(from), size_of::<T>());
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn ask_lines<T>(from: *const T, n: usize) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    for line in 0..n {
        // SAFETY: a hint, which may name any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(from.wrapping_byte_add(64 * line).cast()) };
    }
}

/// Finds the crossings and cases of a layer.
pub(super) fn fill_layer(
    cpu: Detected,
    counts: &Counts,
    planes: [&BitPlane; 2],
    dims: (usize, usize),
    cells: Cells,
    out: &mut Layer,
) {
    let words = planes[0].row_words();
    dispatch!(
        cpu,
        out.fill_with(planes, dims, cells, |rows, mask, out| {
            row_cells(counts, rows, words, mask, out)
        }),
        out.fill_with(planes, dims, cells, |rows, mask, out| {
            row_cells(counts, rows, words, mask, out)
        }),
        avx2::fill_layer(counts, planes, dims, cells, out),
        avx512::fill_layer(counts, planes, dims, cells, out)
    );
}

/// Writes the triangles of a layer.
pub(super) fn emit(cpu: Detected, triangles: &Triangles<'_>, out: &mut [u32]) {
    dispatch!(
        cpu,
        triangles.emit_portable(out),
        triangles.emit_portable(out),
        avx2::emit(triangles, out),
        avx512::emit(triangles, out)
    );
}

/// Makes the vertices of a layer, with their normals where those are wanted.
pub(super) fn vertices<T: Sample>(cpu: Detected, edges: &LayerEdges<'_, T>, out: LayerSlots<'_>) {
    dispatch!(
        cpu,
        portable_vertices(edges, out),
        portable_vertices(edges, out),
        avx2::vertices(edges, out),
        vertices512::vertices(edges, out)
    );
}

/// Makes the vertices on the X edges of a plane, then those on its Y edges.
pub(super) fn ghosts<T: Sample>(
    cpu: Detected,
    placing: &Placing,
    plane: Plane<'_, T>,
    out: &mut [Position],
) {
    let with = Instructions { gather: Gathered::add, place: place_one_by_one };
    dispatch!(
        cpu,
        placing.ghosts_with(plane, out, &with),
        placing.ghosts_with(plane, out, &with),
        avx2::ghosts(placing, plane, out),
        vertices512::ghosts(placing, plane, out)
    );
}

fn portable_vertices<T: Sample>(edges: &LayerEdges<'_, T>, out: LayerSlots<'_>) {
    let gather = Gathered::add;
    match &edges.around {
        None => edges.make_with(out, &Instructions { gather, place: place_one_by_one }),
        Some(around) => {
            let place =
                |f: &Family<'_, T>, g: &Gathered, out: Slots<'_>| around.vertices(f, g, out);
            edges.make_with(out, &Instructions { gather, place });
        }
    }
}

fn place_one_by_one<T: Sample>(family: &Family<'_, T>, edges: &Gathered, out: Slots<'_>) {
    family.place(edges, out.positions);
}
