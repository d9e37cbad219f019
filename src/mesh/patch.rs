//! The surface of one slab, or of a part of one.

use super::measure::face_normal;
use super::{Position, Triangle};

/// Vertices and triangles of consecutive layers, at their final ids. Patches of a surface come in
/// order: the vertices of one begin where those of the one before ended.
///
/// A triangle names vertices by id in the whole mesh, as `u32`. Those of this patch's triangles
/// lie in this patch, or are among its *ghosts*: the vertices on the plane it shares with the
/// patch before, repeated here (the same bits) so that every triangle's corners are at hand.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    /// The id of `vertices[0]`, ghosts included.
    pub first_id: u32,
    /// How many vertices at the front belong to the patch before.
    pub n_ghosts: usize,
    /// Ghosts, then the patch's own vertices.
    pub vertices: Vec<Position>,
    /// One unit normal a vertex, in step with `vertices`; empty where none were asked for.
    pub normals: Vec<[f32; 3]>,
    /// Counter-clockwise seen from outside; ids in the whole mesh.
    pub triangles: Vec<Triangle>,
    /// One unit normal a triangle, or empty: left here by [`Measure::of`](super::Measure::of), so
    /// that they are computed once.
    pub face_normals: Vec<[f32; 3]>,
}

impl Patch {
    /// The vertices that are this patch's own.
    pub fn own_vertices(&self) -> &[Position] {
        &self.vertices[self.n_ghosts..]
    }

    /// The normals of the patch's own vertices; empty where none were asked for.
    pub fn own_normals(&self) -> &[[f32; 3]] {
        self.normals.get(self.n_ghosts..).unwrap_or_default()
    }

    /// The unit normal of triangle `n`, zero where its corners lie on one line.
    pub fn face_normal(&self, n: usize) -> [f32; 3] {
        self.face_normals
            .get(n)
            .copied()
            .unwrap_or_else(|| face_normal(self.corners(self.triangles[n])))
    }

    /// The positions of a triangle's corners.
    pub fn corners(&self, triangle: Triangle) -> [Position; 3] {
        triangle.map(|id| self.vertices[(id - self.first_id) as usize])
    }
}
