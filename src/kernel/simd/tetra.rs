//! Marching tetrahedra: the choice among instruction sets.

use super::super::bits::BitPlane;
use super::super::cpu::{Cpu, Detected};
use super::super::region::Region;
use super::super::tetra::{Between, Crossings, Kind, TetraTriangles};
use super::super::vertices::Placing;
#[cfg(target_arch = "x86_64")]
use super::{avx2, avx512};
use crate::mesh::Position;
use crate::volume::Sample;

/// Counts the crossed diagonals of a kind.
pub(in super::super) fn count(
    cpu: Detected,
    region: Region,
    kind: Kind,
    [low, high]: [&BitPlane; 2],
    out: &mut Crossings,
) {
    dispatch!(
        cpu,
        out.fill_with(region, kind, low, high),
        out.fill_with(region, kind, low, high),
        avx2::count_diagonals(region, kind, [low, high], out),
        avx2::count_diagonals(region, kind, [low, high], out)
    );
}

/// Makes the vertices on diagonals of one kind.
pub(in super::super) fn vertices<T: Sample>(
    cpu: Detected,
    placing: &Placing,
    between: &Between<'_, T>,
    out: &mut [Position],
) {
    dispatch!(
        cpu,
        between.place(placing, out),
        between.place(placing, out),
        avx2::diagonal_vertices(placing, between, out),
        avx2::diagonal_vertices(placing, between, out)
    );
}

/// Writes the triangles of a layer.
pub(in super::super) fn emit(cpu: Detected, triangles: &TetraTriangles<'_>, out: &mut [u32]) {
    dispatch!(
        cpu,
        triangles.emit_portable(out),
        triangles.emit_portable(out),
        avx2::emit_tetra(triangles, out),
        avx512::emit_tetra(triangles, out)
    );
}
