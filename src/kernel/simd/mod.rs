//! The loops of the kernel, compiled once an instruction set, and the choice among them.
//!
//! Each set has a file whose functions are safe and enabled for that set. What is `unsafe` is only
//! the call of such a function from here, after [`Cpu`] said that the processor has the set: a
//! `Cpu` above `Sse2` comes from detection alone. Each set gives the same bits as the plain code,
//! which is the definition.
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
mod sse2;

use super::bits::BitPlane;
use super::cpu::Cpu;
use super::emit::Triangles;
use super::key::Threshold;
use super::layer::{ActiveWord, Cells, Counts, Layer, row_cells};
use super::vertices::{LayerVertices, Placing, Plane};
use crate::geom::vec3::Vec3;
use crate::mesh::Position;
use crate::volume::Sample;

/// Runs the widest function that `cpu` allows.
macro_rules! dispatch {
    ($cpu:expr, $scalar:expr, $sse2:expr, $avx2:expr, $avx512:expr) => {
        match $cpu {
            Cpu::Scalar => $scalar,
            #[cfg(target_arch = "x86_64")]
            Cpu::Sse2 => $sse2,
            // SAFETY: `Cpu` names a set only where the processor was found to have it.
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
                cpu: Cpu,
                samples: &[$key],
                threshold: Threshold<$key>,
                open: bool,
                out: &mut BitPlane,
            ) {
                dispatch!(
                    cpu,
                    out.fill_with(samples, open, |chunk| threshold.word(chunk)),
                    // SAFETY: every x86-64 processor has SSE2.
                    unsafe { sse2::$key::fill(samples, threshold, open, out) },
                    avx2::$key::fill(samples, threshold, open, out),
                    avx512::$key::fill(samples, threshold, open, out)
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
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    const AHEAD_BYTES: usize = 1024;
    for line in 0..size_of::<T>() {
        let ahead = chunk.as_ptr().wrapping_byte_add(AHEAD_BYTES + 64 * line);
        // SAFETY: a hint, which may name any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(ahead.cast()) };
    }
}

/// Finds the crossings and cases of a layer.
pub(super) fn fill_layer(
    cpu: Cpu,
    counts: &Counts,
    planes: [&BitPlane; 2],
    dims: (usize, usize),
    cells: &Cells,
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
pub(super) fn emit(cpu: Cpu, triangles: &Triangles<'_>, out: &mut [u32]) {
    dispatch!(
        cpu,
        triangles.emit_portable(out),
        triangles.emit_portable(out),
        avx2::emit(triangles, out),
        avx512::emit(triangles, out)
    );
}

/// Makes the vertices of a layer.
pub(super) fn vertices<T: Sample>(
    cpu: Cpu,
    placing: &Placing,
    words: &[ActiveWord],
    planes: [Plane<'_, T>; 2],
    step: Vec3,
    out: LayerVertices<'_>,
) {
    dispatch!(
        cpu,
        placing.layer_with(words, planes, step, out, |f, g, out| f.place(g, out)),
        placing.layer_with(words, planes, step, out, |f, g, out| f.place(g, out)),
        avx2::vertices(placing, words, planes, step, out),
        avx512::vertices(placing, words, planes, step, out)
    );
}

/// Makes the vertices on the X edges of a plane, then those on its Y edges.
pub(super) fn ghosts<T: Sample>(
    cpu: Cpu,
    placing: &Placing,
    plane: Plane<'_, T>,
    out: &mut [Position],
) {
    dispatch!(
        cpu,
        placing.ghosts_with(plane, out, |f, g, out| f.place(g, out)),
        placing.ghosts_with(plane, out, |f, g, out| f.place(g, out)),
        avx2::ghosts(placing, plane, out),
        avx512::ghosts(placing, plane, out)
    );
}
