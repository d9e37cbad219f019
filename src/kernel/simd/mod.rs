//! The loops of the kernel, compiled once an instruction set, and the choice among them.
//!
//! Each set has a file whose functions are safe and enabled for that set. What is `unsafe` is only
//! the call of such a function from here, after [`Cpu`] said that the processor has the set: a
//! `Cpu` above `Sse2` comes from detection alone. Each set gives the same bits as the plain code,
//! which is the definition.
#![allow(unsafe_code)]

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
use super::layer::{Cells, Counts, Layer, row_cells};
use super::normal::{Around, Gathered};
use super::vertices::Placing;
use crate::geom::vec3::Vec3;
use crate::mesh::{Normal, Position};
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
        out.fill_with(planes, dims, cells, |rows, cells, cases, slow| {
            row_cells(counts, rows, words, cells, cases, slow)
        }),
        out.fill_with(planes, dims, cells, |rows, cells, cases, slow| {
            row_cells(counts, rows, words, cells, cases, slow)
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

/// Makes the vertices on the X edges of a plane, then those on its Y edges.
pub(super) fn plane_vertices<T: Sample>(
    cpu: Cpu,
    placing: &Placing,
    bits: &BitPlane,
    samples: &[T],
    origin: Vec3,
    out: &mut [Position],
) {
    dispatch!(
        cpu,
        placing.plane(bits, samples, origin, out),
        placing.plane(bits, samples, origin, out),
        avx2::plane_vertices(placing, bits, samples, origin, out),
        avx2::plane_vertices(placing, bits, samples, origin, out)
    );
}

/// Makes the vertices on the Z edges of a layer.
pub(super) fn z_vertices<T: Sample>(
    cpu: Cpu,
    placing: &Placing,
    planes: [&BitPlane; 2],
    samples: [Option<&[T]>; 2],
    between: (Vec3, Vec3),
    out: &mut [Position],
) {
    dispatch!(
        cpu,
        placing.z(planes, samples, between, out),
        placing.z(planes, samples, between, out),
        avx2::z_vertices(placing, planes, samples, between, out),
        avx2::z_vertices(placing, planes, samples, between, out)
    );
}

/// Makes the normals of gathered edges.
pub(super) fn normals<T: Sample, const AXIS: usize>(
    cpu: Cpu,
    around: &Around<'_, T>,
    gathered: &Gathered<T>,
    out: &mut [Normal],
) {
    dispatch!(
        cpu,
        gathered.make::<AXIS>(around, out),
        gathered.make::<AXIS>(around, out),
        avx2::normals::<T, AXIS>(around, gathered, out),
        avx2::normals::<T, AXIS>(around, gathered, out)
    );
}
