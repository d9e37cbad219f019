//! A whole mesh in memory.

use super::{Normal, Position, Topology, Triangle};

/// Vertices and the triangles that share them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions, in the coordinates of the file or run that they come from.
    pub vertices: Vec<Position>,
    /// One normal a vertex, in step with `vertices`; empty where there are none.
    pub normals: Vec<Normal>,
    /// Three indices into `vertices` each, counter-clockwise seen from outside.
    pub triangles: Vec<Triangle>,
}

impl Mesh {
    /// What holds for it as a surface.
    ///
    /// # Panics
    /// A triangle names a vertex that is not there.
    pub fn topology(&self) -> Topology {
        Topology::of(&self.vertices, &self.triangles)
    }
}
